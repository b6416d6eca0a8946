#include "index/refit_tree.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "index/binary_tree.h"
#include "index/block_boxes.h"
#include "index/index_parts.h"
#include "index/index_storage.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// Writes leaves, then boxes from below.
class BlockRefitter {
public:
    /// `blocks` are a copy of the index's.
    BlockRefitter(const IndexParts& index, const TriangleMesh& mesh, IndexFrame frame,
                  std::span<IndexBlock> blocks)
        : index_(index), mesh_(mesh), frame_(std::move(frame)), blocks_(blocks),
          boxes_(blocks.size())
    {}

    /// Leaves in parallel, then nodes from below: these are a seventh of the blocks. False where it was
    /// stopped on request.
    [[nodiscard]] bool refit(std::uint32_t root, Threads threads, Progress* progress)
    {
        std::vector<std::uint32_t> nodes;
        std::vector<std::uint32_t> leaves;
        const auto list = [&](std::uint32_t reference) {
            (is_leaf_reference(reference) ? leaves : nodes).push_back(reference & ~index_leaf_bit);
        };
        list(root);
        for (std::size_t next = 0; next < nodes.size();) {
            for (const std::uint32_t child : blocks_[nodes[next++]].node.children)
                if (child != index_leaf_bit) list(child);
        }
        parallel_chunks(leaves.size(), leaves_per_task, threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(progress)) return;
                            for (std::size_t i = first; i < end; ++i) refit_leaf(leaves[i]);
                        });
        if (is_cancelled(progress)) return false;
        if (is_leaf_reference(root))
            write_extent(blocks_[leaves[0]].leaf, root_extent(boxes_[leaves[0]]));
        // Children before their parents.
        for (std::size_t i = nodes.size(); i-- > 0;) refit_node(nodes[i]);
        return true;
    }

    [[nodiscard]] bool has_exact_leaves() const noexcept { return has_exact_leaves_; }

private:
    static constexpr std::size_t leaves_per_task = 256;

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
    std::atomic<bool> has_exact_leaves_ = true;
};

} // namespace

Result<IndexParts> refit_tree(const IndexParts& index, const TriangleMesh& mesh, Threads threads,
                              Progress* progress)
{
    begin_stage(progress, "moving boxes", 1);
    const IndexFrame frame = index_frame(bounding_box(mesh), has_floats(mesh));
    IndexStorage storage;
    std::ranges::copy(index.blocks(), storage.make_blocks(index.blocks().size()).begin());
    BlockRefitter refitter(index, mesh, frame, storage.blocks);
    if (!refitter.refit(index.root(), threads, progress)) return cancelled("moving boxes");
    storage.ids.assign(index.ids().begin(), index.ids().end());
    storage.tables = move_row_tables(mesh, index.arrays(), frame.scale, threads);
    if (is_cancelled(progress)) return cancelled("moving boxes");
    IndexArrays arrays;
    arrays.center = frame.center;
    arrays.scale = frame.scale;
    arrays.fingerprint = mesh_fingerprint(mesh);
    arrays.root = index.root();
    arrays.has_exact_leaves = refitter.has_exact_leaves();
    advance_stage(progress, 1);
    return index_of(arrays, std::move(storage));
}

} // namespace proxima
