#include "index/build_mesh_index.h"

#include "base/grow_buffer.h"
#include "base/text.h"
#include "index/binary_tree.h"
#include "index/block_runs.h"
#include "index/row_tables.h"
#include "octree/build_octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

namespace proxima {

namespace {

// How far boxes are drawn out, in units of the mesh's size and in steps of a node's grid. The
// kernel computes t of a plane as (32768 + q) (s r) + (g - o) r in floats, u = 2^-24: r = 1 / d is
// off by 2 u, s r by 1 u more, g - o and its product by 1 u each, the first product and the sum by
// 1 u each; |g| <= 32768 s + 1, |o| <= 1.01. Times |d| that is at most u (4 * 33023 s + 5 |plane -
// o| + |o|) < 0.008 s + 12 u. Where the ray's origin was moved to the root it is up to 1 u more,
// and where d was put away from zero less than 1 u (prepare_ray-inl.h).
constexpr double own_margin = 20 * 0x1p-24;
constexpr double step_margin = 1.0 / 64;

// Bytes per triangle at most: keys twice, order, boxes, nodes, rows and blocks.
constexpr std::uint64_t scratch_bytes = 32 + 4 + 24 + sizeof(BinaryNode);
constexpr std::uint64_t index_bytes =
    sizeof(TriangleRow<double>) + sizeof(TriangleId) + 2 * sizeof(IndexBlock);

/// One axis of a node's grid.
struct GridAxis {
    float origin = 0;
    float step = 0;

    /// Takes in [lower, upper] with its margins by bytes 0 to 255: one step is left over on each
    /// side, of which the margins and the rounding of the origin take less than a tenth.
    static GridAxis around(double lower, double upper) noexcept
    {
        constexpr double steps = 253;
        GridAxis axis;
        axis.step = static_cast<float>((upper - lower + 2 * own_margin) / steps);
        const auto step = static_cast<double>(axis.step);
        axis.origin = static_cast<float>(lower - own_margin - step - 32768 * step);
        return axis;
    }
    [[nodiscard]] double plane(std::uint8_t byte) const noexcept
    {
        return static_cast<double>(origin) + (32768.0 + byte) * static_cast<double>(step);
    }
    [[nodiscard]] std::uint8_t below(double value) const noexcept
    {
        return to_byte(std::floor(steps_to(value - own_margin) - step_margin));
    }
    [[nodiscard]] std::uint8_t above(double value) const noexcept
    {
        return to_byte(std::ceil(steps_to(value + own_margin) + step_margin));
    }

private:
    [[nodiscard]] double steps_to(double value) const noexcept
    {
        const auto step_size = static_cast<double>(step);
        return (value - static_cast<double>(origin) - 32768 * step_size) / step_size;
    }
    static std::uint8_t to_byte(double steps) noexcept
    {
        return static_cast<std::uint8_t>(std::clamp(steps, 0.0, 255.0));
    }
};

/// The upper half of the least such float not below the value.
std::uint16_t upper_half(double value) noexcept
{
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    return static_cast<std::uint16_t>((bits >> 16U) + 1);
}

} // namespace

/// On huge pages where the system has them: rays jump about in it.
struct MeshIndexStorage {
    GrowBuffer<std::byte> memory; ///< of the blocks, and room to align them
    std::span<const IndexBlock> blocks;
    RowTables tables;
    std::vector<TriangleId> ids;

    void take(std::span<const IndexBlock> made)
    {
        memory.resize(made.size_bytes() + alignof(IndexBlock));
        void* first = memory.data();
        std::size_t room = memory.size();
        first = std::align(alignof(IndexBlock), made.size_bytes(), first, room);
        std::memcpy(first, made.data(), made.size_bytes());
        blocks = {static_cast<const IndexBlock*>(first), made.size()};
    }
};

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
        constexpr double root_extent = 2.1; // rays come from the box [-1.01, 1.01]
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
        auto storage = std::make_shared<const MeshIndexStorage>(std::move(storage_));
        MeshIndex result;
        result.center_ = tree_.frame.center;
        result.scale_ = tree_.frame.scale;
        result.unscale_ = 1 / tree_.frame.scale;
        result.root_ = root_;
        result.has_exact_leaves_ = has_exact_leaves_;
        result.triangle_count_ = static_cast<std::uint32_t>(tree_.order.size());
        result.blocks_ = storage->blocks;
        result.float_rows_ = storage->tables.float_rows.span();
        result.double_rows_ = storage->tables.double_rows.span();
        result.vertex_places_ = storage->tables.vertex_places.span();
        result.edge_places_ = storage->tables.edge_places.span();
        result.ids_ = storage->ids;
        result.storage_ = std::move(storage);
        return result;
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
        std::array<GridAxis, 3> grid;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            grid[axis] = GridAxis::around(static_cast<double>(box.lower[axis]),
                                          static_cast<double>(box.upper[axis]));
            node.origin[axis] = grid[axis].origin;
            node.step[axis] = grid[axis].step;
        }
        const std::array<int, 8> place = give_places(box);
        std::uint32_t block = first;
        const std::size_t mark = pending.size();
        for (std::size_t slot = 0; slot < 8; ++slot) {
            const auto i = static_cast<std::size_t>(place[slot]);
            const bool used = i < found_.size();
            double extent = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::uint8_t& lower = node.planes[axis][slot];
                std::uint8_t& upper = node.planes[axis][8 + slot];
                lower =
                    used ? grid[axis].below(static_cast<double>(tree_.box(found_[i]).lower[axis]))
                         : 255;
                upper =
                    used ? grid[axis].above(static_cast<double>(tree_.box(found_[i]).upper[axis]))
                         : 0;
                if (used)
                    extent = std::max(extent, grid[axis].plane(upper) - grid[axis].plane(lower));
            }
            node.children[slot] = empty_leaf | index_leaf_bit;
            if (!used) continue;
            node.children[slot] = block | (tree_.is_leaf(found_[i]) ? index_leaf_bit : 0U);
            pending.push_back({found_[i], block++, extent});
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
            const std::uint32_t vertex = vertices[i < count ? i : 0];
            const Vec3& own = mesh_.positions()[vertex];
            const Vec3 p = tree_.frame.to_frame(own);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                leaf.coordinates[axis][i] = static_cast<float>(p[k]);
                has_exact_leaves_ = has_exact_leaves_ && is_float(p[k]) &&
                                    p[k] / tree_.frame.scale + tree_.frame.center[k] == own[k];
            }
        }
        leaf.first_row = at.child.first;
        leaf.count = static_cast<std::uint16_t>(at.child.count);
        leaf.extent_bits = upper_half(at.extent + 4 * own_margin);
        blocks_[at.block].leaf = leaf;
    }

    const TriangleMesh& mesh_;
    const BinaryTree& tree_;
    std::uint32_t root_ = 0;
    bool has_exact_leaves_ = true;
    std::vector<IndexBlock> blocks_;
    MeshIndexStorage storage_;
    std::vector<Child> found_; ///< of the node being written
};

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
