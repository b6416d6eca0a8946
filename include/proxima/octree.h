// Octrees of triangle meshes: cells, the triangles that touch them, inner, outer or boundary.
//
//     auto octree = build_octree(mesh, {.max_depth = 8, .threshold = 8});
//     if (!octree) { std::cerr << describe(octree.error()); return 1; }
//     const OctreeStatistics counts = octree_statistics(*octree);
//     traverse(*octree, visitor);     // should_enter(cell) prunes, visit_leaf(cell, ids) sees leaves
//
// Cells have keys, and octants numbers:
//
//     octant bit 0 = x, bit 1 = y, bit 2 = z; a set bit is the upper half
//     key = 1 followed by one octant (3 bits) per level: root 1, its children 8..15, ...
//
// The tree lies in two arrays:
//
//     nodes       8 bytes each, only for split cells and occupied leaves (uniform trees: all cells)
//       split     { first child record, recorded-children mask 8 | inner-children mask 8 | empty bit }
//       leaf      { first reference, leaf bit 31 | count 31 }
//     references  triangle ids, ascending within a leaf, a leaf's contiguous
//
// An empty child has no record, only a clear bit of the recorded mask; its class is its bit of the
// inner mask. Thesis section 2.1; the overlap tests are those of chapter 3.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <bit>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace PROXIMA_EXPORT proxima {

/// The deepest level a cell may have; the root is depth 0.
inline constexpr int max_octree_depth = 19;

/// A cell's address in any octree: Morton code with a leading one. Ordered by depth, then Morton.
struct CellKey {
    std::uint64_t bits = 1;

    friend constexpr bool operator==(CellKey, CellKey) = default;
    friend constexpr std::strong_ordering operator<=>(CellKey one, CellKey other) noexcept
    {
        return one.bits <=> other.bits;
    }
};

[[nodiscard]] constexpr int depth(CellKey key) noexcept
{
    return (static_cast<int>(std::bit_width(key.bits)) - 1) / 3;
}

/// \pre octant in [0, 8), depth(key) < max_octree_depth
[[nodiscard]] constexpr CellKey child(CellKey key, int octant) noexcept
{
    return {key.bits << 3U | static_cast<std::uint64_t>(octant)};
}

/// \pre depth(key) > 0
[[nodiscard]] constexpr CellKey parent(CellKey key) noexcept
{
    return {key.bits >> 3U};
}

/// Which child of its parent the cell is. \pre depth(key) > 0
[[nodiscard]] constexpr int octant(CellKey key) noexcept
{
    return static_cast<int>(key.bits & 7U);
}

/// Integer coordinates at the cell's depth, each in [0, 2^depth).
[[nodiscard]] std::array<std::uint32_t, 3> cell_coordinates(CellKey key) noexcept;

/// The cell with these coordinates. \pre each in [0, 2^depth), depth in [0, max_octree_depth]
[[nodiscard]] CellKey cell_key(const std::array<std::uint32_t, 3>& coordinates, int depth) noexcept;

/// The root cell in space: a cube, or a box whose cells are boxes of its proportions.
struct OctreeFrame {
    Vec3 lower = Vec3::Zero();
    Vec3 edge = Vec3::Ones(); ///< positive, finite

    /// Coordinate of the plane `index` of the 2^depth + 1 planes on `axis`: a double, the same one
    /// for every cell and depth that it bounds. Cells are closed boxes between such planes, and
    /// every overlap is decided for exactly these boxes.
    [[nodiscard]] double plane(int axis, std::uint32_t index, int depth) const noexcept
    {
        const double part = static_cast<double>(index) / static_cast<double>(1U << depth);
        return lower[axis] + part * edge[axis];
    }
};

/// The closed box of a cell, bounded by OctreeFrame::plane.
[[nodiscard]] Box cell_box(const OctreeFrame& frame, CellKey key) noexcept;

/// Where a cell lies. A cell that a triangle touches is boundary (and so is every split cell that
/// contains such a cell); the others are wholly outside or inside the surface.
enum class CellClass : std::uint8_t { outer, inner, boundary, unclassified };

/// Whether every cell is split to the maximum depth, or only the crowded ones.
enum class Subdivision : std::uint8_t { adaptive, uniform };

/// Which overlap test of a triangle and a cell found an octree's lists (thesis chapter 3).
/// build_octree uses the first; the thesis layer builds with all.
enum class OverlapMethod : std::uint8_t {
    fast,            ///< 17 half-spaces in vector lanes, exact where lanes are unsure
    index_tracking,  ///< thesis 3.5
    minkowski,       ///< thesis 3.2 to 3.4
    separating_axis, ///< thesis 3.6.3
    pairwise         ///< thesis 3.6.2
};

/// One record of the octree; see the picture above.
struct OctreeNode {
    std::uint32_t first = 0;
    std::uint32_t packed = 0;

    static constexpr std::uint32_t leaf_bit = 1U << 31U;
    static constexpr std::uint32_t empty_split_bit = 1U << 30U; ///< split, yet no triangle below

    [[nodiscard]] static constexpr OctreeNode leaf(std::uint32_t first_reference,
                                                   std::uint32_t count) noexcept
    {
        return {first_reference, leaf_bit | count};
    }
    [[nodiscard]] static constexpr OctreeNode split(std::uint32_t first_child,
                                                    std::uint32_t recorded_mask,
                                                    std::uint32_t inner_mask = 0) noexcept
    {
        return {first_child, recorded_mask | inner_mask << 8U};
    }
    [[nodiscard]] constexpr bool is_leaf() const noexcept { return (packed & leaf_bit) != 0; }
    [[nodiscard]] constexpr std::uint32_t count() const noexcept { return packed & ~leaf_bit; }
    /// No triangle touches it: only uniform trees have such records.
    [[nodiscard]] constexpr bool is_empty() const noexcept
    {
        return is_leaf() ? count() == 0 : (packed & empty_split_bit) != 0;
    }
    [[nodiscard]] constexpr std::uint32_t recorded_mask() const noexcept { return packed & 0xFFU; }
    [[nodiscard]] constexpr std::uint32_t inner_mask() const noexcept
    {
        return packed >> 8U & 0xFFU;
    }
    friend constexpr bool operator==(const OctreeNode&, const OctreeNode&) = default;
};
static_assert(sizeof(OctreeNode) == 8);

/// A cell of one octree, as traversals hand it around: a value of 16 bytes.
struct Cell {
    static constexpr std::uint32_t no_node = std::numeric_limits<std::uint32_t>::max();

    CellKey key;
    std::uint32_t node = no_node; ///< its record, no_node for an empty leaf without one
    CellClass type = CellClass::unclassified;
};

/// What the classification of empty leaves met.
struct ClassificationSummary {
    std::uint32_t components = 0;        ///< face-connected components of empty leaves
    std::uint32_t leaked_components = 0; ///< those reaching both sides through a hole of the mesh
    std::uint64_t leaked_leaves = 0;     ///< their leaves, classified one by one
    friend bool operator==(const ClassificationSummary&, const ClassificationSummary&) = default;
};

/// How an octree was built; kept with it and in its file.
struct OctreeParameters {
    int max_depth = 0;
    std::uint32_t threshold = 0;
    OverlapMethod method = OverlapMethod::fast;
    Subdivision subdivision = Subdivision::adaptive;
    bool exact = false;      ///< lists hold exactly the triangles that touch
    bool classified = false; ///< empty leaves are known to be inner or outer
    ClassificationSummary classification = {};
    friend bool operator==(const OctreeParameters&, const OctreeParameters&) = default;
};

/// Immutable; copies share the storage. All members are noexcept, do not allocate, and may be
/// called from any thread. The default one has no nodes: its root is an empty leaf, and queries find
/// nothing.
class Octree {
public:
    [[nodiscard]] const OctreeFrame& frame() const noexcept { return frame_; }
    [[nodiscard]] const OctreeParameters& parameters() const noexcept { return parameters_; }
    [[nodiscard]] std::span<const OctreeNode> nodes() const noexcept { return nodes_; }
    [[nodiscard]] std::span<const TriangleId> references() const noexcept { return references_; }

    /// Triangles of the mesh it was built from.
    [[nodiscard]] std::uint64_t triangle_count() const noexcept { return triangle_count_; }

    /// Bytes of nodes and references.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return nodes_.size_bytes() + references_.size_bytes();
    }

    [[nodiscard]] Cell root() const noexcept
    {
        return nodes_.empty() ? Cell{} : Cell{CellKey{}, 0, CellClass::boundary};
    }

    [[nodiscard]] bool is_leaf(const Cell& cell) const noexcept
    {
        return cell.node == Cell::no_node || nodes_[cell.node].is_leaf();
    }

    /// \pre !is_leaf(cell), octant in [0, 8)
    [[nodiscard]] Cell child(const Cell& cell, int octant) const noexcept
    {
        const OctreeNode parent_node = nodes_[cell.node];
        const std::uint32_t bit = 1U << static_cast<unsigned>(octant);
        const CellClass empty_type = !parameters_.classified            ? CellClass::unclassified
                                     : (parent_node.inner_mask() & bit) ? CellClass::inner
                                                                        : CellClass::outer;
        if ((parent_node.recorded_mask() & bit) == 0) {
            return {proxima::child(cell.key, octant), Cell::no_node, empty_type};
        }
        const auto rank =
            static_cast<std::uint32_t>(std::popcount(parent_node.recorded_mask() & (bit - 1)));
        const std::uint32_t record = parent_node.first + rank;
        return {proxima::child(cell.key, octant), record,
                nodes_[record].is_empty() ? empty_type : CellClass::boundary};
    }

    /// Ids of the triangles that touch the leaf, ascending; empty for inner and outer ones.
    /// \pre is_leaf(cell)
    [[nodiscard]] std::span<const TriangleId> triangles(const Cell& cell) const noexcept
    {
        if (cell.node == Cell::no_node) return {};
        const OctreeNode node = nodes_[cell.node];
        return references_.subspan(node.first, node.count());
    }

    [[nodiscard]] Box box(const Cell& cell) const noexcept { return cell_box(frame_, cell.key); }

    /// Takes arrays that satisfy the layout above; `storage` keeps them alive. For builders, the
    /// file reader and editors that make a changed copy; they check, this does not.
    [[nodiscard]] static Octree adopt(const OctreeFrame& frame, const OctreeParameters& parameters,
                                      std::uint64_t triangle_count,
                                      std::span<const OctreeNode> nodes,
                                      std::span<const TriangleId> references,
                                      std::shared_ptr<const void> storage) noexcept;

private:
    OctreeFrame frame_;
    OctreeParameters parameters_;
    std::uint64_t triangle_count_ = 0;
    std::span<const OctreeNode> nodes_;
    std::span<const TriangleId> references_;
    std::shared_ptr<const void> storage_;
};

enum class RootShape : std::uint8_t { cube, box };

/// Whether empty leaves are found to be inner or outer (costs winding numbers).
enum class Classification : std::uint8_t { inner_outer, none };

struct OctreeOptions {
    int max_depth = 5;           ///< 0 to max_octree_depth; the root is depth 0
    std::uint32_t threshold = 1; ///< a cell splits iff it has more triangles and may be deeper
    Subdivision subdivision = Subdivision::adaptive;
    RootShape root_shape = RootShape::cube; ///< tight on the bounding box: cube or box of its shape
    std::optional<OctreeFrame> root = {};   ///< this root instead; must contain the mesh
    Classification classification = Classification::inner_outer;
    Execution execution = {}; ///< budget: result and scratch, without the mesh
};

/// Builds the octree; the same bits for any number of threads and any instruction set.
/// Errors: invalid_argument (depth, root), invalid_mesh (empty, NaN, beyond 1e100), budget_exceeded,
/// limit_exceeded (2^31 cells or references), cancelled. Leaves list exactly the triangles that touch the
/// closed cell. Cost: linear in the references, a few tens of nanoseconds each: `scripts/bench
/// octree` measures it.
[[nodiscard]] Result<Octree> build_octree(const TriangleMesh& mesh,
                                          const OctreeOptions& options = {});

/// The root that build_octree uses when none is given: centred on the mesh's bounding box and
/// containing it exactly. \pre !box.empty(), finite
[[nodiscard]] OctreeFrame tight_root(const Box& box, RootShape shape) noexcept;

template <class V>
concept CellVisitor = requires(V visitor, const Cell& cell, std::span<const TriangleId> triangles)
{
    {
        visitor.should_enter(cell)
        } -> std::convertible_to<bool>;
    {
        visitor.visit_leaf(cell, triangles)
        } -> std::same_as<Flow>;
};

/// Visits a cell and those below it depth first in Morton order, empty leaves included. Never
/// allocates: each level leaves at most seven siblings pending. Thread safe.
template <class V>
requires CellVisitor<std::remove_reference_t<V>>
void traverse_below(const Octree& octree, const Cell& from, V&& visitor)
{
    std::array<Cell, 7 * max_octree_depth + 1> pending;
    std::size_t count = 0;
    pending[count++] = from;
    while (count != 0) {
        const Cell cell = pending[--count];
        if (!visitor.should_enter(cell)) continue;
        if (octree.is_leaf(cell)) {
            if (visitor.visit_leaf(cell, octree.triangles(cell)) == Flow::stop) return;
        } else {
            for (int octant = 7; octant >= 0; --octant)
                pending[count++] = octree.child(cell, octant);
        }
    }
}

/// Visits all cells, as traverse_below() does those below one.
template <class V>
requires CellVisitor<std::remove_reference_t<V>>
void traverse(const Octree& octree, V&& visitor)
{
    traverse_below(octree, octree.root(), std::forward<V>(visitor));
}

/// What `octree_statistics` counts. Cells include empty leaves that have no record.
struct OctreeStatistics {
    std::uint64_t total = 0; ///< all cells: 8 per split cell, and the root
    std::uint64_t leaves = 0;
    std::uint64_t occupied_leaves = 0; ///< leaves that some triangle touches
    double occupied_percent = 0.0;     ///< occupied leaves per 100 leaves

    std::uint32_t min_triangles = 0; ///< shortest list of an occupied leaf
    std::uint32_t max_triangles = 0; ///< longest list
    std::uint64_t references = 0;    ///< sum of all lists: the thesis's Pointers

    // Lengths of lists; "std" is the standard deviation of the whole population (divided by its
    // size), so a tree of one leaf has 0.
    double mean_triangles = 0.0;  ///< over occupied leaves
    double std_triangles = 0.0;   ///< over occupied leaves
    double mean_all_leaves = 0.0; ///< over all leaves, as in the thesis's table 2.3
    double std_all_leaves = 0.0;  ///< over all leaves

    // Leaves by class.
    std::uint64_t inner = 0;
    std::uint64_t outer = 0;
    std::uint64_t boundary = 0;
    std::uint64_t unclassified = 0;

    int depth_reached = 0;   ///< depth of the deepest cell
    std::uint64_t bytes = 0; ///< Octree::bytes()
    std::array<std::uint64_t, max_octree_depth + 1> leaves_at_depth{};
};

/// Counts once through the octree. Sums are exact integers, so the figures have the same bits on
/// every machine. O(cells), no allocation, thread safe.
[[nodiscard]] OctreeStatistics octree_statistics(const Octree& octree) noexcept;

} // namespace proxima
