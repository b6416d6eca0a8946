// The proximity octree of a convex mesh as the thesis has it: the baseline, and the oracle for
// convex input (thesis 4.3.1, 4.3.3).
//
//     auto octree = build_thesis_proximity_octree(mesh, {.max_depth = 5});
//     if (const auto cell = octree->locate(p))
//         for (const std::uint32_t id : octree->closest(*cell, FeatureKind::face)) ...
//
//     nodes     { index of the first of 8 children } or { leaf bit 31 | leaf }
//     leaf      what it lists: [vertices | edges | faces], of each kind those that touch it first
//     inner     lists nothing
//     outer     lists every feature whose exterior Voronoi region meets the closed cell
//     boundary  the same, and tells which features touch the closed cell
//
// The root is larger than the mesh. Boundary cells are split by the features that touch them, outer
// ones by those they are closest to. Edges between coplanar faces are left out: points closest to
// one are as close to the faces at its sides.
#pragma once

#include "base/fixed_stack.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/thesis.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace proxima {

/// One leaf, and what it lists.
struct ThesisLeaf {
    std::uint32_t first = 0;                    ///< of its labels
    std::array<std::uint32_t, 3> closest = {};  ///< how many, by kind
    std::array<std::uint32_t, 3> touching = {}; ///< those of them that touch the cell, by kind
    CellClass type = CellClass::outer;
};

/// A leaf as queries hand it around.
struct ThesisCell {
    CellKey key;
    std::uint32_t leaf = 0;
};

/// Sizes of the mesh it was built from.
struct FeatureCounts {
    std::size_t vertices = 0;
    std::size_t edges = 0;
    std::size_t faces = 0;
};

/// Immutable; copies share the storage. All members are noexcept, do not allocate, and may be
/// called from any thread.
class ThesisProximityOctree {
public:
    static constexpr std::uint32_t leaf_bit = 1U << 31U;

    [[nodiscard]] const OctreeFrame& frame() const noexcept { return parts_->frame; }
    [[nodiscard]] int max_depth() const noexcept { return parts_->max_depth; }
    [[nodiscard]] const KindThresholds& thresholds() const noexcept { return parts_->thresholds; }
    [[nodiscard]] double margin() const noexcept { return parts_->margin; }
    [[nodiscard]] const FeatureCounts& features() const noexcept { return parts_->features; }

    /// Of the deepest leaf: no search takes more steps.
    [[nodiscard]] int depth_reached() const noexcept { return parts_->depth_reached; }
    [[nodiscard]] std::size_t node_count() const noexcept { return parts_->nodes.size(); }
    [[nodiscard]] std::span<const ThesisLeaf> leaves() const noexcept { return parts_->leaves; }
    /// The lengths of all lists together.
    [[nodiscard]] std::size_t reference_count() const noexcept { return parts_->labels.size(); }
    /// Of nodes, leaves and lists.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// The leaf that holds the point; nothing outside the root and for NaN. A point on a border
    /// belongs to the upper cell. At most depth_reached() steps.
    [[nodiscard]] std::optional<ThesisCell> locate(const Vec3& point) const noexcept;

    [[nodiscard]] CellClass type(const ThesisCell& cell) const noexcept
    {
        return parts_->leaves[cell.leaf].type;
    }

    /// The ids of a kind that some point of the closed cell outside the mesh is closest to; those
    /// that touch the cell first, each part ascending. Empty for inner cells.
    [[nodiscard]] std::span<const std::uint32_t> closest(const ThesisCell& cell,
                                                         FeatureKind kind) const noexcept
    {
        const ThesisLeaf& leaf = parts_->leaves[cell.leaf];
        std::size_t first = leaf.first;
        for (std::size_t k = 0; k < static_cast<std::size_t>(kind); ++k) first += leaf.closest[k];
        return std::span(parts_->labels)
            .subspan(first, leaf.closest[static_cast<std::size_t>(kind)]);
    }

    /// The ids of a kind that touch the closed cell, ascending; empty for all but boundary cells.
    [[nodiscard]] std::span<const std::uint32_t> touching(const ThesisCell& cell,
                                                          FeatureKind kind) const noexcept
    {
        const ThesisLeaf& leaf = parts_->leaves[cell.leaf];
        return closest(cell, kind).first(leaf.touching[static_cast<std::size_t>(kind)]);
    }

    /// How many features the leaf lists.
    [[nodiscard]] std::uint32_t list_length(const ThesisCell& cell) const noexcept
    {
        const ThesisLeaf& leaf = parts_->leaves[cell.leaf];
        return leaf.closest[0] + leaf.closest[1] + leaf.closest[2];
    }

    [[nodiscard]] Box box(const ThesisCell& cell) const noexcept
    {
        return cell_box(frame(), cell.key);
    }

    /// Calls visit(cell) for every leaf, in Morton order.
    template <class Visit>
    void for_each_leaf(Visit&& visit) const
    {
        struct Pending {
            CellKey key;
            std::uint32_t node = 0;
        };
        FixedStack<Pending, 7 * max_octree_depth + 1> pending;
        pending.push({});
        while (!pending.empty()) {
            const Pending at = pending.pop();
            const std::uint32_t node = parts_->nodes[at.node];
            if ((node & leaf_bit) != 0) {
                visit(ThesisCell{at.key, node & ~leaf_bit});
                continue;
            }
            for (int octant = 7; octant >= 0; --octant)
                pending.push({child(at.key, octant), node + static_cast<std::uint32_t>(octant)});
        }
    }

    /// What an octree is made of; for its builder and its file.
    struct Parts {
        OctreeFrame frame;
        int max_depth = 0;
        KindThresholds thresholds;
        double margin = 0;
        FeatureCounts features;
        std::uint64_t fingerprint = 0; ///< mesh_fingerprint() of the mesh
        int depth_reached = 0;
        std::vector<std::uint32_t> nodes;
        std::vector<ThesisLeaf> leaves;
        std::vector<std::uint32_t> labels;
    };
    explicit ThesisProximityOctree(Parts parts)
        : parts_(std::make_shared<const Parts>(std::move(parts)))
    {}
    [[nodiscard]] const Parts& parts() const noexcept { return *parts_; }

private:
    std::shared_ptr<const Parts> parts_;
};

/// Builds it; the same bits for any number of threads. Errors: invalid_argument (depth, margin,
/// tolerances), invalid_mesh (see check_convex_surface; or coordinates beyond 1e100),
/// limit_exceeded (2^31 cells or 2^32 labels), budget_exceeded, cancelled. Some ten microseconds
/// per feature, and some ten nanoseconds per label of a cell and child.
/// \pre topology is the mesh's
[[nodiscard]] Result<ThesisProximityOctree>
build_thesis_proximity_octree(const TriangleMesh& mesh, const Topology& topology,
                              const ThesisProximityOptions& options = {});

/// The same, with a topology of its own. Errors also as build_topology.
[[nodiscard]] Result<ThesisProximityOctree>
build_thesis_proximity_octree(const TriangleMesh& mesh, const ThesisProximityOptions& options = {});

/// Whether the octree, which may come from a file, was built from this mesh: it has its fingerprint,
/// as many vertices, edges and faces, two triangles at every edge, and one at every vertex that is
/// listed. Queries then stay within all arrays, also those of a forged file. O(features + labels).
/// \pre topology is the mesh's
[[nodiscard]] bool fits_mesh(const ThesisProximityOctree& octree, const TriangleMesh& mesh,
                             const Topology& topology);

} // namespace proxima
