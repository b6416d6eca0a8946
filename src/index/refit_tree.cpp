#include "index/refit_tree.h"

#include "base/progress.h"
#include "index/binary_tree.h"
#include "index/block_boxes.h"
#include "index/index_parts.h"
#include "index/index_storage.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// Writes leaves, then boxes from below.
class BlockRefitter {
public:
    /// `blocks` are a copy of the index's.
    BlockRefitter(const IndexParts& index, const TriangleMesh& mesh, const IndexFrame& frame,
                  std::span<IndexBlock> blocks)
        : index_(index), mesh_(mesh), frame_(frame), blocks_(blocks), boxes_(blocks.size())
    {}

    /// Of a block and all below it.
    void refit(std::uint32_t reference)
    {
        std::vector<std::uint32_t> order{reference};
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (is_leaf_reference(order[i])) continue;
            for (const std::uint32_t child : blocks_[order[i]].node.children)
                if (child != index_leaf_bit) order.push_back(child);
        }
        if (is_leaf_reference(reference))
            write_extent(blocks_[reference & ~index_leaf_bit].leaf, root_extent);
        // Children before their parents.
        for (std::size_t i = order.size(); i-- > 0;) {
            if (is_leaf_reference(order[i])) {
                refit_leaf(order[i] & ~index_leaf_bit);
            } else {
                refit_node(order[i]);
            }
        }
    }

    [[nodiscard]] bool has_exact_leaves() const noexcept { return has_exact_leaves_; }

private:
    static bool is_leaf_reference(std::uint32_t reference) noexcept
    {
        return (reference & index_leaf_bit) != 0;
    }

    void write_point(IndexLeaf& leaf, std::size_t vertex, const Vec3& point)
    {
        if (!write_vertex(leaf, vertex, point, frame_)) has_exact_leaves_ = false;
    }

    void refit_leaf(std::uint32_t block)
    {
        IndexLeaf& leaf = blocks_[block].leaf;
        // Those that no triangle uses are the first one, which some triangle does.
        const TriangleCorners& first = mesh_.triangles()[to_index(index_.id(leaf.first_row))];
        for (std::size_t i = 0; i < index_width; ++i)
            write_point(leaf, i, mesh_.positions()[first[0]]);
        for (std::uint32_t i = 0; i < leaf.count; ++i) {
            const TriangleCorners& corners =
                mesh_.triangles()[to_index(index_.id(leaf.first_row + i))];
            for (std::size_t k = 0; k < 3; ++k)
                write_point(leaf, leaf.corners[k][i], mesh_.positions()[corners[k]]);
        }
        FloatBox& box = boxes_[block];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.lower[axis] = *std::ranges::min_element(leaf.coordinates[axis]);
            box.upper[axis] = *std::ranges::max_element(leaf.coordinates[axis]);
        }
    }

    void refit_node(std::uint32_t block)
    {
        constexpr float endless = std::numeric_limits<float>::infinity();
        FloatBox& box = boxes_[block];
        box.lower.fill(endless);
        box.upper.fill(-endless);
        IndexNode& node = blocks_[block].node;
        std::array<const FloatBox*, 8> children{};
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const std::uint32_t child = node.children[slot] & ~index_leaf_bit;
            if (child == 0) continue;
            children[slot] = &boxes_[child];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.lower[axis] = std::min(box.lower[axis], boxes_[child].lower[axis]);
                box.upper[axis] = std::max(box.upper[axis], boxes_[child].upper[axis]);
            }
        }
        const std::array<double, 8> extents = write_boxes(node, box, children);
        for (std::size_t slot = 0; slot < 8; ++slot) {
            if (children[slot] != nullptr && is_leaf_reference(node.children[slot]))
                write_extent(blocks_[node.children[slot] & ~index_leaf_bit].leaf, extents[slot]);
        }
    }

    const IndexParts& index_;
    const TriangleMesh& mesh_;
    IndexFrame frame_;
    std::span<IndexBlock> blocks_;
    std::vector<FloatBox> boxes_; ///< of blocks, once they are written
    bool has_exact_leaves_ = true;
};

} // namespace

Result<IndexParts> refit_tree(const IndexParts& index, const TriangleMesh& mesh, Threads threads,
                              Progress* progress)
{
    begin_stage(progress, "numbering edges", mesh.triangle_count());
    const auto edges = number_edges(mesh, progress);
    if (!edges) return tl::unexpected(edges.error());
    const IndexFrame frame = index_frame(bounding_box(mesh), has_floats(mesh));
    IndexStorage storage;
    std::ranges::copy(index.blocks(), storage.make_blocks(index.blocks().size()).begin());
    BlockRefitter refitter(index, mesh, frame, storage.blocks);
    refitter.refit(index.root());
    storage.ids.assign(index.ids().begin(), index.ids().end());
    storage.tables = make_row_tables(mesh, *edges, storage.ids, threads);
    IndexArrays arrays;
    arrays.center = frame.center;
    arrays.scale = frame.scale;
    arrays.fingerprint = mesh_fingerprint(mesh);
    arrays.root = index.root();
    arrays.has_exact_leaves = refitter.has_exact_leaves();
    return index_of(arrays, std::move(storage));
}

} // namespace proxima
