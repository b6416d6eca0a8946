#include "proxima/mesh_index.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/binary_tree.h"
#include "index/block_boxes.h"
#include "index/build_part_index.h"
#include "index/index_parts.h"
#include "index/index_storage.h"
#include "proxima/function_ref.h"
#include "proxima/octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace proxima {

namespace {

// Bytes per triangle at most: keys twice, order, boxes twice, nodes, rows and blocks.
constexpr std::uint64_t scratch_bytes = 32 + 4 + 48 + sizeof(BinaryNode) + edge_number_bytes;
constexpr std::uint64_t index_bytes =
    sizeof(TriangleRow<double>) + sizeof(TriangleId) + 2 * sizeof(IndexBlock) + 24;
constexpr std::uint32_t triangles_of_part = 8192;

} // namespace

namespace detail {

/// A node or leaf of the tree that is yet to be written.
struct PendingBlock {
    BinaryTree::Child child;
    std::uint32_t block;
    double extent; ///< the largest edge of the box that queries meet it by
};

constexpr std::uint32_t empty_leaf = 0; ///< what unused slots refer to

/// The runs that cover one best, by at most `most`; in their order.
void cover(const BinaryTree& tree, const BinaryTree::Child& child, std::uint32_t most,
           std::vector<BinaryTree::Child>& found)
{
    if (tree.is_single(child, most)) {
        found.push_back(child);
        return;
    }
    const auto [left, right] = tree.children(child);
    const std::uint32_t share = tree.left_share(child.node, most);
    cover(tree, left, share, found);
    cover(tree, right, most - share, found);
}

/// The children of a wide node.
void find_children(const BinaryTree& tree, const BinaryTree::Child& child,
                   std::vector<BinaryTree::Child>& found)
{
    const auto [left, right] = tree.children(child);
    const std::uint32_t share = tree.left_share(child.node, index_width);
    cover(tree, left, share, found);
    cover(tree, right, index_width - share, found);
}

/// How many blocks lie below a run's own, and not below those that `set_aside` takes.
template <class SetAside>
std::uint32_t count_blocks(const BinaryTree& tree, const BinaryTree::Child& top,
                           const SetAside& set_aside)
{
    std::uint32_t count = 0;
    std::vector<BinaryTree::Child> pending{top};
    while (!pending.empty()) {
        const BinaryTree::Child at = pending.back();
        pending.pop_back();
        if (set_aside(at) || tree.is_leaf(at)) continue;
        const std::size_t before = pending.size();
        find_children(tree, at, pending);
        count += static_cast<std::uint32_t>(pending.size() - before);
    }
    return count;
}

// Writes blocks depth first, the children of a node side by side.
class BlockWriter {
public:
    /// New blocks are those from `next` on.
    BlockWriter(const TriangleMesh& mesh, const BinaryTree& tree, std::span<IndexBlock> blocks,
                std::uint32_t next)
        : mesh_(mesh), tree_(tree), blocks_(blocks), next_(next)
    {}

    /// Writes `top` and what lies below it, but for the blocks that `set_aside` takes.
    template <class SetAside>
    void write(const PendingBlock& top, const SetAside& set_aside)
    {
        std::vector<PendingBlock> pending{top};
        while (!pending.empty()) {
            const PendingBlock at = pending.back();
            pending.pop_back();
            if (set_aside(at)) continue;
            if (tree_.is_leaf(at.child)) {
                write_leaf(at);
            } else {
                write_node(at, pending);
            }
        }
    }
    [[nodiscard]] bool has_exact_leaves() const noexcept { return has_exact_leaves_; }

private:
    using Child = BinaryTree::Child;

    /// Assigns children to the slots of octants: child_of[slot] = child or none. What lies on the side of
    /// an octant gains by how far; greedily, then by swaps of two.
    [[nodiscard]] std::array<int, 8> assign_slots(const FloatBox& box) const
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
        std::array<int, 8> child_of{0, 1, 2, 3, 4, 5, 6, 7}; // gain's row in each slot
        const auto gain_of = [&](std::size_t slot, int row) {
            return gain[static_cast<std::size_t>(row)][slot];
        };
        for (bool better = true; better;) {
            better = false;
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = a + 1; b < 8; ++b) {
                    const float now = gain_of(a, child_of[a]) + gain_of(b, child_of[b]);
                    const float swapped = gain_of(a, child_of[b]) + gain_of(b, child_of[a]);
                    if (!(swapped > now + 1e-6F * std::abs(now))) continue;
                    std::swap(child_of[a], child_of[b]);
                    better = true;
                }
            }
        }
        return child_of;
    }

    void write_node(const PendingBlock& at, std::vector<PendingBlock>& pending)
    {
        found_.clear();
        find_children(tree_, at.child, found_);
        std::uint32_t block = next_;
        next_ += static_cast<std::uint32_t>(found_.size());
        IndexNode& node = blocks_[at.block].node;
        const FloatBox& box = tree_.box(at.child);
        const std::array<int, 8> child_of = assign_slots(box);
        std::array<const FloatBox*, 8> boxes{};
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const auto i = static_cast<std::size_t>(child_of[slot]);
            if (i < found_.size()) boxes[slot] = &tree_.box(found_[i]);
        }
        const std::array<double, 8> extents = write_boxes(node, box, boxes);
        const std::size_t mark = pending.size();
        for (std::size_t slot = 0; slot < 8; ++slot) {
            node.children[slot] = empty_leaf | index_leaf_bit;
            if (boxes[slot] == nullptr) continue;
            const Child& child = found_[static_cast<std::size_t>(child_of[slot])];
            node.children[slot] = block | (tree_.is_leaf(child) ? index_leaf_bit : 0U);
            pending.push_back({child, block++, extents[slot]});
        }
        std::reverse(pending.begin() + static_cast<std::ptrdiff_t>(mark), pending.end());
        write_runs(at.child.first, child_of, node);
    }

    /// Which rows lie below which slot.
    void write_runs(std::uint32_t first_row, const std::array<int, 8>& child_of,
                    IndexNode& node) const
    {
        node.first_row = first_row;
        node.order = ~0U;
        node.starts.fill(0);
        // Children were found in the order of their rows.
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const auto i = static_cast<std::size_t>(child_of[slot]);
            if (i >= found_.size()) continue;
            node.order ^= (IndexNode::no_child ^ static_cast<std::uint32_t>(slot)) << 4 * i;
            node.starts[slot] = static_cast<std::uint16_t>(
                std::min(found_[i].first - first_row, std::uint32_t{IndexNode::far_start}));
        }
    }

    void write_leaf(const PendingBlock& at)
    {
        IndexLeaf leaf = {};
        std::array<std::uint32_t, index_width> vertices{};
        std::size_t count = 0;
        for (std::uint32_t i = 0; i < at.child.count; ++i) {
            const TriangleCorners& corners =
                mesh_.triangles()[to_index(tree_.order[at.child.first + i])];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto end = vertices.begin() + static_cast<std::ptrdiff_t>(count);
                const auto found = std::find(vertices.begin(), end, corners[k]);
                if (found == end) vertices[count++] = corners[k];
                leaf.corners[k][i] = static_cast<std::uint8_t>(found - vertices.begin());
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3& point = mesh_.positions()[vertices[i]];
            if (!write_vertex(leaf, i, point, tree_.frame)) has_exact_leaves_ = false;
        }
        for (std::array<float, 8>& axis : leaf.coordinates)
            std::fill(axis.begin() + static_cast<std::ptrdiff_t>(count), axis.end(), axis[0]);
        leaf.first_row = at.child.first;
        leaf.count = static_cast<std::uint16_t>(at.child.count);
        write_extent(leaf, at.extent);
        blocks_[at.block].leaf = leaf;
    }

    const TriangleMesh& mesh_;
    const BinaryTree& tree_;
    std::span<IndexBlock> blocks_;
    std::uint32_t next_;
    bool has_exact_leaves_ = true;
    std::vector<Child> found_; ///< of the node being written, in the order of their rows
};

} // namespace detail

using detail::BlockWriter;
using detail::count_blocks;
using detail::empty_leaf;
using detail::PendingBlock;

// The steps of build_mesh_index, in the order of their calls there.
class MeshIndexWriter {
public:
    MeshIndexWriter(const TriangleMesh& mesh, BinaryTree tree) : mesh_(mesh), tree_(std::move(tree))
    {}

    /// The top of the tree first, then side by side the parts below it. `beside` is called
    /// meanwhile, by one thread.
    bool write_blocks(Threads threads, Progress* progress, FunctionRef<void()> beside)
    {
        root_ = 1U | (tree_.is_leaf(tree_.root()) ? index_leaf_bit : 0U);
        const auto is_part = [](const BinaryTree::Child& at) {
            return at.count <= triangles_of_part;
        };
        std::vector<BinaryTree::Child> tops;
        const std::uint32_t top_end = 2 + count_blocks(tree_, tree_.root(), [&](const auto& at) {
                                          if (is_part(at)) tops.push_back(at);
                                          return is_part(at);
                                      });
        std::ranges::sort(tops, {}, &BinaryTree::Child::first);
        std::vector<std::uint32_t> ends(tops.size(), 0);
        parallel_for(tops.size(), threads, [&](std::size_t i) {
            ends[i] = count_blocks(tree_, tops[i], [](const auto&) { return false; });
        });
        std::uint32_t end = top_end;
        for (std::uint32_t& each : ends) each = end += each;
        const std::span<IndexBlock> blocks = storage_.make_blocks(end);
        blocks[empty_leaf].leaf = {};
        std::vector<PendingBlock> parts; // with the positions that the top gives them
        BlockWriter top(mesh_, tree_, blocks, 2);
        const double extent = root_extent(tree_.box(tree_.root()));
        top.write({tree_.root(), 1, extent}, [&](const PendingBlock& at) {
            if (is_part(at.child)) parts.push_back(at);
            return is_part(at.child);
        });
        std::ranges::sort(parts, {}, [](const PendingBlock& at) { return at.child.first; });
        std::vector<unsigned char> is_exact(parts.size(), 0);
        parallel_for(1 + parts.size(), threads, [&](std::size_t task) {
            if (is_cancelled(progress)) return;
            if (task == 0) return beside();
            const std::size_t i = task - 1;
            BlockWriter writer(mesh_, tree_, blocks, i == 0 ? top_end : ends[i - 1]);
            writer.write(parts[i], [](const PendingBlock&) { return false; });
            is_exact[i] = writer.has_exact_leaves() ? 1 : 0;
            advance_stage(progress, parts[i].child.count);
        });
        has_exact_leaves_ = std::ranges::all_of(is_exact, [](auto exact) { return exact != 0; });
        tree_.boxes = {};
        tree_.nodes = {};
        return !is_cancelled(progress);
    }

    void write_rows(const EdgeNumbers& edges, Threads threads)
    {
        storage_.tables = make_row_tables(mesh_, edges, tree_.order, tree_.frame.scale, threads);
    }

    MeshIndex result()
    {
        storage_.ids = std::move(tree_.order);
        IndexArrays arrays;
        arrays.center = tree_.frame.center;
        arrays.scale = tree_.frame.scale;
        arrays.fingerprint = mesh_fingerprint(mesh_);
        arrays.root = root_;
        arrays.has_exact_leaves = has_exact_leaves_;
        return make_mesh_index(index_of(arrays, std::move(storage_)));
    }

private:
    const TriangleMesh& mesh_;
    BinaryTree tree_;
    std::uint32_t root_ = 0;
    bool has_exact_leaves_ = true;
    IndexStorage storage_;
};

namespace {

/// What makes an index besides its mesh. Without edges, they are numbered.
struct IndexPlan {
    Box box; ///< of the mesh
    IndexFrame frame;
    const EdgeNumbers* edges = nullptr;
};

Status check_limits(const TriangleMesh& mesh, const MeshIndexOptions& options)
{
    if (mesh.triangle_count() > max_index_triangles) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a mesh index has at most ", max_index_triangles,
                           " triangles, this mesh has ", mesh.triangle_count()));
    }
    const std::uint64_t needed = mesh.triangle_count() * (scratch_bytes + index_bytes);
    return check_budget(options.execution.budget, needed, "the mesh index", "raise the budget");
}

Result<MeshIndex> build_index(const TriangleMesh& mesh, const IndexPlan& plan,
                              const MeshIndexOptions& options)
{
    if (Status status = check_limits(mesh, options); !status) return tl::unexpected(status.error());
    const PageReserve reserve;
    Progress* const progress = options.execution.progress;
    auto tree = build_binary_tree(mesh, plan.frame, tight_root(plan.box, RootShape::cube),
                                  options.execution.threads, progress);
    if (!tree) return tl::unexpected(tree.error());
    MeshIndexWriter writer(mesh, std::move(*tree));
    begin_stage(progress, "writing mesh index", 2 * mesh.triangle_count());
    Result<EdgeNumbers> numbered;
    const auto number = [&] {
        if (plan.edges == nullptr) numbered = number_edges(mesh, progress);
    };
    if (!writer.write_blocks(options.execution.threads, progress, number) || !numbered)
        return cancelled("building the mesh index");
    writer.write_rows(plan.edges != nullptr ? *plan.edges : *numbered, options.execution.threads);
    return writer.result();
}

} // namespace

Result<MeshIndex> build_mesh_index(const TriangleMesh& mesh, const MeshIndexOptions& options)
{
    const Result<Box> box = checked_bounding_box(mesh);
    if (!box) return tl::unexpected(box.error());
    return build_index(mesh, {*box, index_frame(*box, has_floats(mesh))}, options);
}

Result<MeshIndex> build_part_index(const TriangleMesh& part, const IndexFrame& frame,
                                   const EdgeNumbers& edges, const MeshIndexOptions& options)
{
    const Result<Box> box = checked_bounding_box(part);
    if (!box) return tl::unexpected(box.error());
    return build_index(part, {*box, frame, &edges}, options);
}

} // namespace proxima
