#include "octree/grow_subtree.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"

#include <limits>
#include <utility>

namespace proxima {

namespace {

/// Bytes of one pair: triangle, centre and mask.
constexpr std::uint64_t pair_bytes = 5 * sizeof(std::uint32_t);

std::uint64_t bytes(const SplitLevel& level) noexcept
{
    return level.triangle.capacity() * pair_bytes + level.cells.capacity() * sizeof(SplitCell);
}

} // namespace

Status SubtreeGrower::reserve(std::uint64_t children, const OctreeOutput& output)
{
    if (output.references.size() + children > std::numeric_limits<std::uint32_t>::max() / 2) {
        return fail(ErrorCode::limit_exceeded,
                    "the octree needs more than 2^31 triangle references: lower the depth or "
                    "raise the threshold");
    }
    const std::uint64_t now = bytes(output) + bytes(level_) + bytes(next_);
    const std::uint64_t used =
        limits_.used_bytes.fetch_add(now - counted_bytes_) + now - counted_bytes_;
    counted_bytes_ = now;
    // The children stay as references or as pairs of the next level.
    return check_budget({limits_.budget_bytes}, used + children * pair_bytes, "the octree",
                        "lower the depth, raise the threshold or raise the budget");
}

Result<OctreeNode> SubtreeGrower::grow(const Subtree& subtree, ChildTest& test,
                                       OctreeOutput& output)
{
    const std::size_t count = subtree.triangles.size();
    if (count <= limits_.threshold || subtree.depth >= limits_.max_depth) {
        const std::size_t first = output.references.size();
        output.references.resize(first + count);
        for (std::size_t i = 0; i < count; ++i) {
            output.references[first + i] = TriangleId{subtree.triangles[i]};
        }
        return OctreeNode::leaf(static_cast<std::uint32_t>(first),
                                static_cast<std::uint32_t>(count));
    }

    OctreeNode root;
    test.begin(subtree);
    std::int32_t half = 1 << (snapped_bits - subtree.depth - 1);
    level_.reset(count);
    for (std::size_t i = 0; i < count; ++i) {
        level_.triangle[i] = static_cast<std::uint32_t>(i);
        for (auto& center : level_.center) center[i] = half;
    }
    level_.cells.push_back(
        {SplitCell::no_record, 0, static_cast<std::uint32_t>(count), {half, half, half}});
    level_.pair_count = count;
    level_.pad();

    for (int depth = subtree.depth; level_.pair_count != 0; ++depth, half /= 2) {
        split_pairs_ += level_.pair_count;
        masks_.resize(level_.pair_count + lane_padding);
        test.find_touched(level_, depth, masks_.data());
        if (is_cancelled(limits_.progress)) return cancelled("building the octree");
        const std::uint64_t children = count_children(masks_.data(), level_.pair_count);
        if (auto status = reserve(children, output); !status) return tl::unexpected(status.error());
        const SplitRule rule{.threshold = limits_.threshold,
                             .children_are_deepest = depth + 1 >= limits_.max_depth,
                             .child_half = half / 2};
        distribute_children(level_, masks_.data(), children, subtree.triangles.data(), rule, next_,
                            output, root);
        std::swap(level_, next_);
    }
    return root;
}

} // namespace proxima
