// How the winding numbers of two regions of empty cells differ: signed crossings of a line between
// them, counted exactly.
//
//     +-------+---+---+-------+   A ray along an axis leaves an empty cell, passes leaves that hold
//     | empty | l | l | empty |   triangles, and ends at the next empty cell of another region or
//     |     --+--/+---+-->    |   outside the root. Every triangle that it crosses is listed in a
//     +-------+-/-+---+-------+   leaf that it passes. Crossed outwards, it takes 1 away.
#pragma once

#include "base/disjoint_sets.h"
#include "octree/empty_cells.h"
#include "octree/empty_regions.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// Each ray looks at every cap; where there are more, winding numbers are found otherwise.
inline constexpr std::size_t most_caps_for_rays = 20'000;

/// Casts rays. What it refers to must outlive it. Thread safe. In a part of an octree, leaves with a
/// record and without triangles are what the part lacks: no ray passes them.
class RegionRays {
public:
    /// Three axes, each both ways.
    static constexpr int directions = 6;

    /// Where a ray ends.
    struct End {
        std::uint32_t region = EmptyRegions::none; ///< none outside the root
        std::int32_t change = 0; ///< winding number of mesh and caps there, less that at the start
    };

    /// `caps` closes the mesh's holes (hole_caps.h): crossings of both count.
    /// \pre octree was built from mesh and octree.parameters().exact
    RegionRays(const Octree& octree, const TriangleMesh& mesh, const TriangleMesh& caps,
               const EmptyGroups& groups, const EmptyRegions& regions);

    /// What one ray after the other uses, on one thread.
    struct Scratch {
        struct Crossed {
            TriangleId id = {};
            std::int32_t change = 0;
        };
        std::vector<std::uint32_t> passed; ///< records of leaves, since the last region
        std::vector<Crossed> crossed;      ///< their triangles on the ray, with repeats
    };

    /// The ray of a region in one direction; nothing where it meets an edge or a vertex, or no end
    /// soon. O(leaves passed times depth, and caps).
    [[nodiscard]] std::optional<End> cast(std::uint32_t region, int direction,
                                          Scratch& scratch) const;

    [[nodiscard]] std::uint32_t region_count() const noexcept { return regions_.count(); }

private:
    struct Ray;

    /// The cell of the lattice of deepest cells at this location.
    struct Location {
        bool is_empty = false;
        std::uint32_t id = 0; ///< group of an empty cell, record of a leaf
        int depth = 0;
    };

    [[nodiscard]] Location locate(const std::array<std::uint32_t, 3>& at) const noexcept;
    [[nodiscard]] std::optional<std::int32_t> crossings(const Ray& ray, double end,
                                                        Scratch& scratch) const;

    const Octree& octree_;
    const TriangleMesh& mesh_;
    const TriangleMesh& caps_;
    const EmptyGroups& groups_;
    const EmptyRegions& regions_;
};

/// Whether the difference of two winding numbers is known.
[[nodiscard]] inline bool are_tied(DisjointOffsets& windings, std::uint32_t a,
                                   std::uint32_t b) noexcept
{
    return windings.find(a).smallest == windings.find(b).smallest;
}

/// Ties regions to each other and to the outside, which is member region_count() of `windings`,
/// until all are tied to it or all directions were tried. A few rays per region. Less once
/// `progress` is cancelled; the same for any number of threads.
void tie_regions(const RegionRays& rays, DisjointOffsets& windings, Threads threads,
                 Progress* progress);

} // namespace proxima
