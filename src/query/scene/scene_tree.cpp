#include "query/scene/scene_tree.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "index/binary_tree.h"
#include "index/block_boxes.h"
#include "index/index_storage.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr bool is_leaf(std::uint32_t reference) noexcept
{
    return (reference & index_leaf_bit) != 0;
}

/// Copies blocks, with their boxes.
class TreeWriter {
public:
    /// Boxes are drawn out by the margin.
    TreeWriter(const IndexParts& order, std::span<const SceneRow> rows, const IndexFrame& frame,
               double margin, std::span<IndexBlock> blocks) noexcept
        : order_(order), rows_(rows), frame_(frame), margin_(Vec3::Constant(margin)),
          blocks_(blocks)
    {}

    /// False where it was cancelled.
    [[nodiscard]] bool write(const Execution& execution)
    {
        blocks_[0] = order_.blocks()[0]; // the empty leaf that nodes without all children refer to
        // The top of the tree, breadth first, until there are enough subtrees for all threads.
        constexpr std::size_t enough = 512;
        std::vector<TopBlock> top = {{order_.root(), {}, 0}};
        std::size_t opened = 0;
        while (opened < top.size() && top.size() < enough) {
            TopBlock& at = top[opened++];
            if (is_leaf(at.reference)) continue;
            at.first_child = top.size();
            for (const std::uint32_t child : children_of(at.reference))
                top.push_back({child, {}, 0});
        }
        parallel_for(top.size() - opened, execution.threads, [&](std::size_t i) {
            if (!is_cancelled(execution.progress))
                top[opened + i].box = write_below(top[opened + i].reference);
        });
        if (is_cancelled(execution.progress)) return false;
        while (opened-- > 0) {
            TopBlock& at = top[opened];
            if (is_leaf(at.reference)) {
                at.box = write_leaf(at.reference & ~index_leaf_bit);
                continue;
            }
            std::size_t child = at.first_child;
            at.box = write_node(at.reference,
                                [&](std::uint32_t /*reference*/) { return top[child++].box; });
        }
        return true;
    }

private:
    struct TopBlock {
        std::uint32_t reference;
        FloatBox box;
        std::size_t first_child;
    };

    /// By slots.
    [[nodiscard]] std::vector<std::uint32_t> children_of(std::uint32_t block) const
    {
        const IndexNode& node = order_.blocks()[block].node;
        std::vector<std::uint32_t> children;
        for (std::size_t slot = 0; slot < 8; ++slot)
            if (node.has_child(slot)) children.push_back(node.children[slot]);
        return children;
    }

    FloatBox write_below(std::uint32_t reference) noexcept
    {
        if (is_leaf(reference)) return write_leaf(reference & ~index_leaf_bit);
        return write_node(reference, [&](std::uint32_t child) { return write_below(child); });
    }

    FloatBox write_leaf(std::uint32_t block) noexcept
    {
        blocks_[block] = order_.blocks()[block];
        const IndexLeaf& leaf = blocks_[block].leaf;
        Box all;
        for (const SceneRow& row : rows_.subspan(leaf.first_row, leaf.count)) {
            all.lower = all.lower.cwiseMin(row.box.lower);
            all.upper = all.upper.cwiseMax(row.box.upper);
        }
        const Vec3 lower = frame_.to_frame(all.lower - margin_);
        const Vec3 upper = frame_.to_frame(all.upper + margin_);
        FloatBox box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            box.lower[axis] = static_cast<float>(lower[k]);
            box.upper[axis] = static_cast<float>(upper[k]);
        }
        return box;
    }

    /// box_of(reference) is called once for each child, by slots.
    template <class BoxOf>
    FloatBox write_node(std::uint32_t block, const BoxOf& box_of) noexcept
    {
        constexpr float endless = std::numeric_limits<float>::infinity();
        blocks_[block] = order_.blocks()[block];
        IndexNode& node = blocks_[block].node;
        FloatBox all;
        all.lower.fill(endless);
        all.upper.fill(-endless);
        std::array<FloatBox, 8> boxes;
        std::array<const FloatBox*, 8> children{};
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (!node.has_child(slot)) continue;
            boxes[slot] = box_of(node.children[slot]);
            children[slot] = &boxes[slot];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                all.lower[axis] = std::min(all.lower[axis], boxes[slot].lower[axis]);
                all.upper[axis] = std::max(all.upper[axis], boxes[slot].upper[axis]);
            }
        }
        write_boxes(node, all, children);
        return all;
    }

    const IndexParts& order_;
    std::span<const SceneRow> rows_;
    IndexFrame frame_;
    Vec3 margin_;
    std::span<IndexBlock> blocks_;
};

} // namespace

std::optional<MeshIndex> tree_about(const IndexParts& order, std::span<const SceneRow> rows,
                                    const Box& all, const Execution& execution)
{
    // One of the tree's units is at most the extent.
    const double margin = scene_tree_margin * all.extent().maxCoeff();
    const Vec3 out = Vec3::Constant(margin);
    const IndexFrame frame = index_frame({all.lower - out, all.upper + out}, false);
    IndexStorage storage;
    storage.make_blocks(order.blocks().size());
    TreeWriter writer(order, rows, frame, margin, storage.blocks);
    if (!writer.write(execution)) return std::nullopt;
    storage.ids.assign(order.ids().begin(), order.ids().end());
    IndexArrays arrays;
    arrays.center = frame.center;
    arrays.scale = frame.scale;
    arrays.root = order.root();
    return make_mesh_index(index_of(arrays, std::move(storage)));
}

} // namespace proxima
