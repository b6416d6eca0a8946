#include "query/scene/scene_tree.h"

#include "base/parallel.h"
#include "base/progress.h"
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

constexpr std::uint32_t block_of(std::uint32_t reference) noexcept
{
    return reference & ~index_leaf_bit;
}

/// Draws the boxes of a scene's blocks.
class TreeBoxes {
public:
    TreeBoxes(SceneParts& scene, IndexFrame frame) noexcept
        : scene_(scene), frame_(std::move(frame)),
          // One of the tree's units is at most the extent.
          margin_(Vec3::Constant(scene_tree_margin * scene.all.extent().maxCoeff()))
    {}

    /// About a leaf's rows, drawn out by the margin.
    [[nodiscard]] FloatBox about_leaf(std::uint32_t block) const noexcept
    {
        const IndexLeaf& leaf = scene_.blocks[block].leaf;
        Box all;
        for (const SceneRow& row : std::span(scene_.rows).subspan(leaf.first_row, leaf.count)) {
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

    /// Sets a node's planes by its children's boxes. The box about them all.
    [[nodiscard]] FloatBox write_node(std::uint32_t block) const noexcept
    {
        constexpr float endless = std::numeric_limits<float>::infinity();
        IndexNode& node = scene_.blocks[block].node;
        FloatBox all;
        all.lower.fill(endless);
        all.upper.fill(-endless);
        std::array<const FloatBox*, 8> children{};
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (!node.has_child(slot)) continue;
            const FloatBox& box = scene_.boxes[block_of(node.children[slot])].box;
            children[slot] = &box;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                all.lower[axis] = std::min(all.lower[axis], box.lower[axis]);
                all.upper[axis] = std::max(all.upper[axis], box.upper[axis]);
            }
        }
        write_boxes(node, all, children);
        return all;
    }

private:
    SceneParts& scene_;
    IndexFrame frame_;
    Vec3 margin_;
};

/// Copies blocks and draws their boxes, from the leaves up.
class TreeWriter {
public:
    /// \pre the scene has as many blocks as the order
    TreeWriter(SceneParts& scene, const IndexParts& order, const IndexFrame& frame) noexcept
        : scene_(scene), boxes_(scene, frame), order_(order.blocks()), root_(order.root())
    {}

    /// False where it was cancelled.
    [[nodiscard]] bool write(const Execution& execution)
    {
        scene_.blocks[0] = order_[0]; // the empty leaf that nodes without all children refer to
        // The top of the tree, breadth first, until there are enough subtrees for all threads.
        constexpr std::size_t enough = 512;
        std::vector<std::uint32_t> top = {root_};
        std::size_t opened = 0;
        while (opened < top.size() && top.size() < enough) {
            const std::uint32_t at = top[opened++];
            if (is_leaf(at)) continue;
            for_each_child(at, [&](std::uint32_t child) { top.push_back(child); });
        }
        parallel_for(top.size() - opened, execution.threads, [&](std::size_t i) {
            if (!is_cancelled(execution.progress)) write_below(top[opened + i]);
        });
        if (is_cancelled(execution.progress)) return false;
        while (opened-- > 0) write_block(top[opened]);
        return true;
    }

private:
    template <class Visit>
    void for_each_child(std::uint32_t block, const Visit& visit) const
    {
        const IndexNode& node = order_[block].node;
        for (std::size_t slot = 0; slot < 8; ++slot)
            if (node.has_child(slot)) visit(node.children[slot]);
    }

    void write_below(std::uint32_t reference) noexcept
    {
        if (!is_leaf(reference))
            for_each_child(reference, [&](std::uint32_t child) { write_below(child); });
        write_block(reference);
    }

    /// \pre the blocks below it are written
    void write_block(std::uint32_t reference) noexcept
    {
        const std::uint32_t block = block_of(reference);
        scene_.blocks[block] = order_[block];
        if (!is_leaf(reference)) {
            scene_.boxes[block].box = boxes_.write_node(block);
            for_each_child(
                block, [&](std::uint32_t child) { scene_.boxes[block_of(child)].parent = block; });
            return;
        }
        scene_.boxes[block].box = boxes_.about_leaf(block);
        const IndexLeaf& leaf = scene_.blocks[block].leaf;
        for (SceneRow& row : std::span(scene_.rows).subspan(leaf.first_row, leaf.count))
            row.leaf = block;
    }

    SceneParts& scene_;
    TreeBoxes boxes_;
    std::span<const IndexBlock> order_;
    std::uint32_t root_;
};

/// Gives the scene memory for a tree in the order of another one, in this frame. The tree's arrays.
IndexArrays make_tree_memory(SceneParts& scene, const IndexParts& order, const IndexFrame& frame)
{
    const auto storage = std::make_shared<IndexStorage>();
    scene.blocks = storage->make_blocks(order.blocks().size());
    storage->ids.assign(order.ids().begin(), order.ids().end());
    scene.storage = storage;
    IndexArrays arrays;
    arrays.center = frame.center;
    arrays.scale = frame.scale;
    arrays.root = order.root();
    arrays.blocks = storage->blocks;
    arrays.ids = storage->ids;
    return arrays;
}

IndexFrame frame_of(const IndexParts& tree) noexcept
{
    return {tree.center(), tree.scale()};
}

} // namespace

bool draw_tree(SceneParts& scene, const IndexParts& order, const Execution& execution)
{
    const double margin = scene_tree_margin * scene.all.extent().maxCoeff();
    const Vec3 out = Vec3::Constant(margin);
    const IndexFrame frame = index_frame({scene.all.lower - out, scene.all.upper + out}, false);
    const IndexArrays arrays = make_tree_memory(scene, order, frame);
    scene.boxes.assign(scene.blocks.size(), {});
    if (!TreeWriter(scene, order, frame).write(execution)) return false;
    scene.tree = make_mesh_index(IndexParts::adopt(arrays, scene.storage));
    return true;
}

void redraw_tree(SceneParts& scene, std::span<const std::uint32_t> rows,
                 std::shared_ptr<IndexParts> tree) noexcept
{
    const TreeBoxes boxes(scene, frame_of(scene.tree.parts()));
    for (const std::uint32_t row : rows) {
        std::uint32_t block = scene.rows[row].leaf;
        FloatBox box = boxes.about_leaf(block);
        // What does not change a block's box does not change those above.
        while (box.lower != scene.boxes[block].box.lower ||
               box.upper != scene.boxes[block].box.upper) {
            scene.boxes[block].box = box;
            block = scene.boxes[block].parent;
            if (block == 0) break;
            box = boxes.write_node(block);
        }
    }
    // The root's box is read again.
    *tree = IndexParts::adopt(scene.tree.parts().arrays(), scene.storage);
    scene.tree = MeshIndex(std::move(tree));
}

SceneParts copy_of(const SceneParts& scene)
{
    SceneParts copy = scene;
    if (scene.tree_rows() == 0) return copy;
    const IndexParts& tree = scene.tree.parts();
    const IndexArrays arrays = make_tree_memory(copy, tree, frame_of(tree));
    std::ranges::copy(tree.blocks(), copy.blocks.begin());
    copy.tree = make_mesh_index(IndexParts::adopt(arrays, copy.storage));
    return copy;
}

} // namespace proxima
