#include "haptics/surface/triangle_tree.h"

#include "base/check.h"
#include "base/parallel.h"
#include "base/progress.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr double max_extent = 1e150; // squared distances must be numbers
constexpr std::size_t blocks_per_task = 64;
constexpr float float_endless = std::numeric_limits<float>::infinity();

/// The greatest float that is not above the value, and the least not below it.
float rounded_down(double value) noexcept
{
    const auto nearest = static_cast<float>(value);
    return nearest <= value ? nearest : std::nextafter(nearest, -float_endless);
}
float rounded_up(double value) noexcept
{
    return -rounded_down(-value);
}

std::uint32_t blocks_for(std::uint32_t entries) noexcept
{
    return (entries + TriangleTree::width - 1) / TriangleTree::width;
}

} // namespace

TriangleTreeBlock detail::empty_block() noexcept
{
    TriangleTreeBlock block{};
    for (auto& coordinates : block.lower) coordinates.fill(float_endless);
    for (auto& coordinates : block.upper) coordinates.fill(-float_endless);
    return block;
}

void detail::fill_parents(std::span<const TriangleTree::Level> levels, std::size_t first,
                          std::span<TriangleTreeBlock> blocks) noexcept
{
    constexpr std::uint32_t width = TriangleTree::width;
    for (std::size_t level = first; level < levels.size(); ++level) {
        for (std::uint32_t entry = 0; entry < levels[level].entries; ++entry) {
            const TriangleTreeBlock& below = blocks[levels[level - 1].first_block + entry];
            TriangleTreeBlock& here = blocks[levels[level].first_block + entry / width];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                here.lower[axis][entry % width] = *std::ranges::min_element(below.lower[axis]);
                here.upper[axis][entry % width] = *std::ranges::max_element(below.upper[axis]);
            }
        }
    }
}

std::uint32_t TriangleTree::lay_out(std::uint32_t triangles) noexcept
{
    triangle_count_ = triangles;
    level_count_ = 0;
    std::uint32_t entries = blocks_for(triangles);
    std::uint32_t blocks = 0;
    do {
        levels_[level_count_++] = {blocks, entries};
        entries = blocks_for(entries);
        blocks += entries;
    } while (entries > 1);
    return blocks;
}

std::size_t TriangleTree::block_count(std::uint32_t triangles) noexcept
{
    return TriangleTree().lay_out(triangles);
}

TriangleTree TriangleTree::adopt(const Vec3& origin, double scale, double reach,
                                 std::uint32_t triangles, std::span<const TriangleTreeBlock> blocks,
                                 std::shared_ptr<const void> storage) noexcept
{
    TriangleTree tree;
    PROXIMA_CHECK_EQ(tree.lay_out(triangles), blocks.size());
    tree.origin_ = origin;
    tree.scale_ = scale;
    tree.reach_ = reach;
    tree.blocks_ = blocks;
    tree.storage_ = std::move(storage);
    return tree;
}

// The steps of build_triangle_tree, in the order of their calls there.
class TriangleTreeBuilder {
public:
    TriangleTreeBuilder(const TriangleMesh& from, const TriangleMesh& to,
                        std::span<const TriangleId> order, const Box& bounds)
        : from_(from), to_(to), order_(order)
    {
        tree_.origin_ = bounds.center();
        const std::uint32_t count = tree_.lay_out(static_cast<std::uint32_t>(order.size()));
        blocks_.assign(count, detail::empty_block());
        const double extent = bounds.extent().maxCoeff();
        if (extent > 0)
            tree_.scale_ = std::ldexp(1.0, std::clamp(-std::ilogb(extent), -1000, 1000));
        const double largest =
            std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff());
        // Queries round a coordinate by 2^-52 of itself, features their points by less than 2^-48
        // of the mesh's coordinates.
        tree_.reach_ = largest * tree_.scale_;
        margin_ = 0x1p-26 + 0x1p-48 * tree_.reach_;
    }

    /// The groups of one block of the lowest level.
    void fill_groups(std::uint32_t block) noexcept
    {
        constexpr std::uint32_t width = TriangleTree::width;
        const std::uint32_t first = block * width;
        const std::uint32_t end = std::min(first + width, tree_.levels_[0].entries);
        for (std::uint32_t group = first; group < end; ++group) {
            Box box;
            const std::size_t begin = std::size_t{group} * width;
            const std::size_t count = std::min<std::size_t>(width, order_.size() - begin);
            for (const TriangleId id : order_.subspan(begin, count)) {
                for (const Vec3& vertex : from_.triangle(id).vertices) box.extend(vertex);
                if (&to_ == &from_) continue;
                for (const Vec3& vertex : to_.triangle(id).vertices) box.extend(vertex);
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                const double low = (box.lower[k] - tree_.origin_[k]) * tree_.scale_;
                const double high = (box.upper[k] - tree_.origin_[k]) * tree_.scale_;
                TriangleTreeBlock& at = blocks_[block];
                at.lower[axis][group - first] = rounded_down(low - margin_);
                at.upper[axis][group - first] = rounded_up(high + margin_);
            }
        }
    }

    void fill_parents() noexcept { detail::fill_parents(tree_.levels(), 1, blocks_); }

    [[nodiscard]] std::uint32_t group_blocks() const noexcept
    {
        return blocks_for(tree_.levels_[0].entries);
    }
    [[nodiscard]] TriangleTree result()
    {
        auto storage = std::make_shared<const std::vector<TriangleTreeBlock>>(std::move(blocks_));
        tree_.blocks_ = *storage;
        tree_.storage_ = std::move(storage);
        return std::move(tree_);
    }

private:
    const TriangleMesh& from_;
    const TriangleMesh& to_;
    std::span<const TriangleId> order_;
    double margin_ = 0;
    std::vector<TriangleTreeBlock> blocks_;
    TriangleTree tree_;
};

Result<TriangleTree> build_triangle_tree(const TriangleMesh& mesh,
                                         std::span<const TriangleId> order,
                                         const Execution& execution)
{
    return build_triangle_tree(mesh, mesh, order, execution);
}

Result<TriangleTree> build_triangle_tree(const TriangleMesh& from, const TriangleMesh& to,
                                         std::span<const TriangleId> order,
                                         const Execution& execution)
{
    PROXIMA_CHECK_EQ(order.size(), from.triangle_count());
    PROXIMA_CHECK_EQ(order.size(), to.triangle_count());
    Result<Box> bounds = checked_bounding_box(from);
    if (bounds && &to != &from) {
        const Result<Box> other = checked_bounding_box(to);
        if (!other) return tl::unexpected(other.error());
        bounds->extend(other->lower);
        bounds->extend(other->upper);
    }
    if (!bounds) return tl::unexpected(bounds.error());
    if (!(bounds->extent().maxCoeff() < max_extent)) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh is too large for squared distances to be numbers: scale it down");
    }
    TriangleTreeBuilder builder(from, to, order, *bounds);
    begin_stage(execution.progress, "triangle tree", builder.group_blocks());
    parallel_chunks(builder.group_blocks(), blocks_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(execution.progress)) return;
                        for (std::size_t block = first; block < end; ++block)
                            builder.fill_groups(static_cast<std::uint32_t>(block));
                        advance_stage(execution.progress, end - first);
                    });
    if (is_cancelled(execution.progress)) return cancelled("building the tree of a surface");
    builder.fill_parents();
    return builder.result();
}

} // namespace proxima
