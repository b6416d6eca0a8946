#include "index/check_blocks.h"

#include "base/progress.h"
#include "base/text.h"
#include "index/binary_tree.h"
#include "index/index_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace proxima {

namespace {

/// What lies below a block: rows, and their corners as leaves have them.
struct BlockContent {
    std::uint32_t first_row = 0;
    std::uint32_t end_row = 0;
    std::array<float, 3> lower;
    std::array<float, 3> upper;

    void extend(const BlockContent& other) noexcept
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], other.lower[axis]);
            upper[axis] = std::max(upper[axis], other.upper[axis]);
        }
    }
};

/// What checks return where they find no fault.
constexpr const char* no_fault = nullptr;

constexpr bool is_leaf_reference(std::uint32_t reference) noexcept
{
    return (reference & index_leaf_bit) != 0;
}

constexpr std::uint32_t block_of(std::uint32_t reference) noexcept
{
    return reference & ~index_leaf_bit;
}

class BlockChecker {
public:
    explicit BlockChecker(const IndexParts& index)
        : index_(index), blocks_(index.blocks()), content_(blocks_.size())
    {}

    Status run(const CheckWork& work)
    {
        StageSteps steps = work.steps();
        if (const char* const fault = check_empty_leaf(); fault != no_fault) return bad(fault, 0);
        if (Status status = find_order(); !status) return status;
        for (std::size_t i = order_.size(); i-- > 0;) {
            const std::uint32_t reference = order_[i];
            const std::uint32_t block = block_of(reference);
            const char* const fault = is_leaf_reference(reference)
                                          ? check_leaf(blocks_[block].leaf, content_[block])
                                          : check_node(blocks_[block].node, content_[block]);
            if (fault != no_fault) return bad(fault, block);
            if (!steps.done(sizeof(IndexBlock))) return cancelled("checking the index");
        }
        const BlockContent& all = content_[block_of(index_.root())];
        if (all.first_row != 0 || all.end_row != index_.triangle_count())
            return bad("rows of no leaf", block_of(index_.root()));
        return {};
    }

private:
    static tl::unexpected<Error> bad(const char* fault, std::size_t block)
    {
        return fail(ErrorCode::broken_invariant, fault, concat("block ", block));
    }

    [[nodiscard]] const char* check_empty_leaf() const
    {
        if (blocks_.empty() || blocks_.size() >= index_leaf_bit) return "impossible number";
        return blocks_[0].leaf.count == 0 ? check_lanes(blocks_[0].leaf) : "it is not empty";
    }

    /// All blocks from the root down, parents before their children.
    Status find_order()
    {
        std::vector<bool> named(blocks_.size());
        const auto add = [&](std::uint32_t reference) {
            const std::uint32_t block = block_of(reference);
            if (block == 0 || block >= blocks_.size() || named[block]) return false;
            named[block] = true;
            order_.push_back(reference);
            return true;
        };
        if (!add(index_.root())) return bad("no such root", block_of(index_.root()));
        std::size_t done = 0;
        for (std::size_t level = 1; done < order_.size(); ++level) {
            if (level > IndexParts::max_levels)
                return bad("too many levels", block_of(order_[done]));
            for (const std::size_t end = order_.size(); done < end; ++done) {
                const std::uint32_t reference = order_[done];
                if (is_leaf_reference(reference)) continue;
                for (const std::uint32_t child : blocks_[reference].node.children) {
                    if (child != index_leaf_bit && !add(child))
                        return bad("a child that is none, or twice", reference);
                }
            }
        }
        if (order_.size() + 1 != blocks_.size()) return bad("blocks of no node", 0);
        return {};
    }

    /// Corners and coordinates, which lanes read beyond the last triangle as well.
    [[nodiscard]] const char* check_lanes(const IndexLeaf& leaf) const
    {
        // The largest double in units of the least scale.
        const float most = index_.scale() <= least_index_scale ? 0x1p24F : 1.0F;
        for (const auto& corners : leaf.corners) {
            if (*std::ranges::max_element(corners) >= 8) return "no such corner";
        }
        for (const auto& line : leaf.coordinates) {
            for (const float number : line)
                if (!(std::abs(number) <= most)) return "a vertex outside of the frame";
        }
        return no_fault;
    }

    const char* check_leaf(const IndexLeaf& leaf, BlockContent& content) const
    {
        if (leaf.count == 0 || leaf.count > 8) return "impossible number of triangles";
        if (leaf.count > index_.triangle_count() ||
            leaf.first_row > index_.triangle_count() - leaf.count)
            return "no such rows";
        if (const char* const fault = check_lanes(leaf); fault != no_fault) return fault;
        for (std::uint32_t i = 0; i < leaf.count; ++i) {
            const Triangle triangle = index_.triangle(leaf.first_row + i);
            for (std::size_t corner = 0; corner < 3; ++corner) {
                if (!is_vertex(leaf, leaf.corners[corner][i], triangle.vertices[corner]))
                    return "a corner that is not its row's";
            }
        }
        content.first_row = leaf.first_row;
        content.end_row = leaf.first_row + leaf.count;
        float edge = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            content.lower[axis] = *std::ranges::min_element(leaf.coordinates[axis]);
            content.upper[axis] = *std::ranges::max_element(leaf.coordinates[axis]);
            edge = std::max(edge, content.upper[axis] - content.lower[axis]);
        }
        const auto extent =
            std::bit_cast<float>(static_cast<std::uint32_t>(leaf.extent_bits) << 16U);
        return extent >= edge && std::isfinite(extent) ? no_fault : "the extent is too small";
    }

    /// Whether a leaf's vertex is the point, rounded, or exactly where leaves are said to be exact.
    [[nodiscard]] bool is_vertex(const IndexLeaf& leaf, std::size_t vertex, const Vec3& point) const
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            const float number = leaf.coordinates[axis][vertex];
            const double own = (point[k] - index_.center()[k]) * index_.scale();
            if (number != static_cast<float>(own)) return false;
            if (index_.has_exact_leaves() &&
                double{number} * index_.unscale() + index_.center()[k] != point[k])
                return false;
        }
        return true;
    }

    const char* check_node(const IndexNode& node, BlockContent& content) const
    {
        constexpr float endless = std::numeric_limits<float>::infinity();
        content.lower.fill(endless);
        content.upper.fill(-endless);
        std::array<std::uint32_t, 8> children{};
        std::size_t count = 0;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const std::uint32_t child = block_of(node.children[slot]);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if ((node.planes[axis][slot] > node.planes[axis][8 + slot]) != (child == 0))
                    return "a box of no child, or none of one";
                if (child != 0 && !holds(node, axis, slot, content_[child]))
                    return "a box that does not hold what is below";
            }
            if (child == 0) continue;
            content.extend(content_[child]);
            std::size_t k = count++;
            for (; k > 0 && content_[children[k - 1]].first_row > content_[child].first_row; --k)
                children[k] = children[k - 1];
            children[k] = child;
        }
        if (count == 0) return "no child";
        for (std::size_t i = 1; i < count; ++i) {
            if (content_[children[i - 1]].end_row != content_[children[i]].first_row)
                return "rows that are not one run";
        }
        content.first_row = content_[children[0]].first_row;
        content.end_row = content_[children[count - 1]].end_row;
        return has_runs(node, std::span(children).first(count))
                   ? no_fault
                   : "the order of its children is wrong";
    }

    /// Whether a node says where its children's rows begin. `children`: blocks in the order of rows
    [[nodiscard]] bool has_runs(const IndexNode& node,
                                std::span<const std::uint32_t> children) const
    {
        const std::uint32_t first_row = content_[children.front()].first_row;
        if (node.first_row != first_row) return false;
        for (std::uint32_t k = 0; k < 8; ++k) {
            const std::uint32_t slot = node.order >> 4 * k & 15U;
            if ((slot == IndexNode::no_child) != (k >= children.size())) return false;
            if (slot == IndexNode::no_child) continue;
            if (slot >= 8 || block_of(node.children[slot]) != children[k]) return false;
            const std::uint32_t start = content_[children[k]].first_row - first_row;
            if (node.starts[slot] != std::min(start, std::uint32_t{IndexNode::far_start}))
                return false;
        }
        return true;
    }

    static bool holds(const IndexNode& node, std::size_t axis, std::size_t slot,
                      const BlockContent& child)
    {
        return node.plane(axis, slot) <= double{child.lower[axis]} &&
               node.plane(axis, 8 + slot) >= double{child.upper[axis]};
    }

    const IndexParts& index_;
    std::span<const IndexBlock> blocks_;
    std::vector<std::uint32_t> order_;  ///< references
    std::vector<BlockContent> content_; ///< of blocks from the end of the order on
};

} // namespace

Status check_blocks(const IndexParts& index, const CheckWork& work)
{
    return BlockChecker(index).run(work);
}

} // namespace proxima
