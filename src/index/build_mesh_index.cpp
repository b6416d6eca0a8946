#include "index/build_mesh_index.h"

#include "base/text.h"
#include "index/binary_tree.h"
#include "index/block_boxes.h"
#include "index/block_runs.h"
#include "index/index_storage.h"
#include "octree/build_octree.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace proxima {

namespace {

// Bytes per triangle at most: keys twice, order, boxes, nodes, rows and blocks.
constexpr std::uint64_t scratch_bytes = 32 + 4 + 24 + sizeof(BinaryNode);
constexpr std::uint64_t index_bytes =
    sizeof(TriangleRow<double>) + sizeof(TriangleId) + 2 * sizeof(IndexBlock);

// Writes the blocks of a tree, depth first.
class MeshIndexWriter {
public:
    MeshIndexWriter(const TriangleMesh& mesh, const BinaryTree& tree) : mesh_(mesh), tree_(tree) {}

    bool write_blocks(Progress* progress)
    {
        StageSteps steps(progress, "writing mesh index", tree_.order.size());
        blocks_.resize(2);
        // The empty leaf that unused places refer to.
        blocks_[empty_leaf].leaf = {};
        std::vector<Pending> pending;
        root_ = 1U | (tree_.is_leaf(tree_.root()) ? index_leaf_bit : 0U);
        pending.push_back({tree_.root(), 1, root_extent});
        while (!pending.empty()) {
            const Pending at = pending.back();
            pending.pop_back();
            if (tree_.is_leaf(at.child)) {
                write_leaf(at);
                if (!steps.done(at.child.count)) return false;
            } else {
                write_node(at, pending);
            }
        }
        return true;
    }

    void write_rows(const Topology& topology)
    {
        storage_.tables = make_row_tables(mesh_, topology, tree_.order);
    }

    MeshIndex result()
    {
        write_runs(blocks_, root_);
        storage_.take(blocks_);
        storage_.ids = tree_.order;
        MeshIndexParts parts;
        parts.center = tree_.frame.center;
        parts.scale = tree_.frame.scale;
        parts.fingerprint = mesh_fingerprint(mesh_);
        parts.root = root_;
        parts.has_exact_leaves = has_exact_leaves_;
        return index_of(parts, std::move(storage_));
    }

private:
    using Child = BinaryTree::Child;

    static constexpr std::uint32_t empty_leaf = 0;

    struct Pending {
        Child child;
        std::uint32_t block;
        double extent; ///< the largest edge of the box that rays meet it by
    };

    /// The boxes that cover a node best, by at most `most`.
    void cover(const Child& child, std::uint32_t most, std::vector<Child>& found) const
    {
        if (most == 1 || child.count == 1 || tree_.cost(child, most) == tree_.cost(child, 1)) {
            found.push_back(child);
            return;
        }
        open(child, most, found);
    }
    void open(const Child& child, std::uint32_t most, std::vector<Child>& found) const
    {
        const auto [left, right] = tree_.children(child.node);
        const std::uint32_t share = tree_.left_share(child.node, most);
        cover(left, share, found);
        cover(right, most - share, found);
    }

    /// Gives children the places of octants: place[slot] = child or none. What lies on the side of
    /// an octant gains by how far; greedily, then by swaps of two.
    [[nodiscard]] std::array<int, 8> give_places(const FloatBox& box) const
    {
        std::array<std::array<float, 8>, 8> gain{}; // of children, then of nothing: zero
        for (std::size_t i = 0; i < found_.size(); ++i) {
            const FloatBox& own = tree_.box(found_[i]);
            for (std::size_t slot = 0; slot < 8; ++slot) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const float off =
                        (own.lower[axis] + own.upper[axis]) - (box.lower[axis] + box.upper[axis]);
                    gain[i][slot] += (slot >> axis & 1U) != 0 ? off : -off;
                }
            }
        }
        std::array<int, 8> place{0, 1, 2, 3, 4, 5, 6, 7}; // gain's row in each slot
        const auto gain_of = [&](std::size_t slot, int row) {
            return gain[static_cast<std::size_t>(row)][slot];
        };
        for (bool better = true; better;) {
            better = false;
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = a + 1; b < 8; ++b) {
                    const float now = gain_of(a, place[a]) + gain_of(b, place[b]);
                    const float swapped = gain_of(a, place[b]) + gain_of(b, place[a]);
                    if (!(swapped > now + 1e-6F * std::abs(now))) continue;
                    std::swap(place[a], place[b]);
                    better = true;
                }
            }
        }
        return place;
    }

    void write_node(const Pending& at, std::vector<Pending>& pending)
    {
        found_.clear();
        open(at.child, index_width, found_);
        const auto first = static_cast<std::uint32_t>(blocks_.size());
        blocks_.resize(first + found_.size());
        IndexNode& node = blocks_[at.block].node;
        const FloatBox& box = tree_.box(at.child);
        const std::array<int, 8> place = give_places(box);
        std::array<const FloatBox*, 8> boxes{};
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const auto i = static_cast<std::size_t>(place[slot]);
            if (i < found_.size()) boxes[slot] = &tree_.box(found_[i]);
        }
        const std::array<double, 8> extents = write_boxes(node, box, boxes);
        std::uint32_t block = first;
        const std::size_t mark = pending.size();
        for (std::size_t slot = 0; slot < 8; ++slot) {
            node.children[slot] = empty_leaf | index_leaf_bit;
            if (boxes[slot] == nullptr) continue;
            const Child& child = found_[static_cast<std::size_t>(place[slot])];
            node.children[slot] = block | (tree_.is_leaf(child) ? index_leaf_bit : 0U);
            pending.push_back({child, block++, extents[slot]});
        }
        std::reverse(pending.begin() + static_cast<std::ptrdiff_t>(mark), pending.end());
    }

    void write_leaf(const Pending& at)
    {
        IndexLeaf leaf = {};
        std::array<std::uint32_t, index_width> vertices{};
        std::size_t count = 0;
        for (std::uint32_t i = 0; i < at.child.count; ++i) {
            const TriangleCorners& corners =
                mesh_.triangles()[index(tree_.order[at.child.first + i])];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto end = vertices.begin() + static_cast<std::ptrdiff_t>(count);
                const auto place = std::find(vertices.begin(), end, corners[k]);
                if (place == end) vertices[count++] = corners[k];
                leaf.corners[k][i] = static_cast<std::uint8_t>(place - vertices.begin());
            }
        }
        for (std::size_t i = 0; i < index_width; ++i) {
            const Vec3& point = mesh_.positions()[vertices[i < count ? i : 0]];
            if (!write_vertex(leaf, i, point, tree_.frame)) has_exact_leaves_ = false;
        }
        leaf.first_row = at.child.first;
        leaf.count = static_cast<std::uint16_t>(at.child.count);
        write_extent(leaf, at.extent);
        blocks_[at.block].leaf = leaf;
    }

    const TriangleMesh& mesh_;
    const BinaryTree& tree_;
    std::uint32_t root_ = 0;
    bool has_exact_leaves_ = true;
    std::vector<IndexBlock> blocks_;
    IndexStorage storage_;
    std::vector<Child> found_; ///< of the node being written
};

} // namespace

Result<MeshIndex> build_mesh_index(const TriangleMesh& mesh, const MeshIndexOptions& options)
{
    const Result<Box> box = checked_bounding_box(mesh);
    if (!box) return tl::unexpected(box.error());
    if (mesh.triangle_count() > max_index_triangles) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a mesh index has at most ", max_index_triangles,
                           " triangles, this mesh has ", mesh.triangle_count()));
    }
    const std::uint64_t needed = mesh.triangle_count() * (scratch_bytes + index_bytes);
    if (auto status = check_budget(options.budget, needed, "the mesh index", "raise the budget");
        !status)
        return tl::unexpected(status.error());
    const auto topology = build_topology(
        mesh, {.threads = options.threads, .budget = options.budget, .progress = options.progress});
    if (!topology) return tl::unexpected(topology.error());
    const auto tree = build_binary_tree(mesh, *box, tight_root(*box, RootShape::cube),
                                        options.threads, options.progress);
    if (!tree) return tl::unexpected(tree.error());
    MeshIndexWriter writer(mesh, *tree);
    if (!writer.write_blocks(options.progress))
        return fail(ErrorCode::cancelled, "mesh index: stopped on request");
    writer.write_rows(*topology);
    return writer.result();
}

} // namespace proxima
