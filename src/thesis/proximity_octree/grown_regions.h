// Voronoi regions grown by a cube of any size: which of them meet a cell (thesis 4.3.3, 3.5).
//
//     a region meets the cube of centre c and half size h   <=>   c is in region (+) h cube
//     one facet of that sum:   normal . c <= offset + h * growth
//
// The sum with the cube of half size 1 is built once per feature; each facet rests on the same pair
// of vertices at every size (index tracking), so that a cell costs one dot product per facet.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "thesis/proximity_octree/convex_surface.h"
#include "thesis/proximity_octree/feature_numbers.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// The half-space normal . c <= offset + h * growth, rounding allowed for.
struct GrowingPlane {
    Vec3 normal = Vec3::Zero(); ///< of length 1
    double offset = 0;
    double growth = 0;
};

struct GrownRegionsOptions {
    Execution execution = {}; ///< budget: result and scratch
};

/// The planes of all features of a convex mesh. Immutable; members may be called from any thread.
class GrownRegions {
public:
    /// Whether the feature has a region: no flat edge, and no vertex that no triangle uses.
    [[nodiscard]] bool has_region(std::uint32_t number) const noexcept
    {
        return first_[number] != first_[number + 1];
    }

    [[nodiscard]] std::span<const GrowingPlane> planes(std::uint32_t number) const noexcept
    {
        return std::span(planes_).subspan(first_[number], first_[number + 1] - first_[number]);
    }

    /// Whether the closed region meets the closed cube, in the root that was named: never false for
    /// one that does; true for one that misses it by less than the allowance for rounding.
    /// \pre has_region(number)
    [[nodiscard]] bool meets(std::uint32_t number, const Vec3& centre,
                             double half_size) const noexcept
    {
        return std::ranges::all_of(planes(number), [&](const GrowingPlane& plane) {
            return plane.normal.dot(centre) <= plane.offset + half_size * plane.growth;
        });
    }

    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return planes_.size() * sizeof(GrowingPlane) + first_.size() * sizeof(std::uint32_t);
    }

private:
    friend Result<GrownRegions> grow_regions(const TriangleMesh& mesh, const Topology& topology,
                                             const ConvexSurface& surface, const OctreeFrame& root,
                                             const GrownRegionsOptions& options);

    std::vector<std::uint32_t> first_; ///< by feature number
    std::vector<GrowingPlane> planes_;
};

/// Sums the region of every feature with the cube, for cells of this root. Faces at flat edges have
/// the edges' regions in theirs. The same bits for any number of threads. Errors: budget_exceeded,
/// cancelled, and those of minkowski_sum. Some ten microseconds per feature.
/// \pre topology and surface are the mesh's, root contains it
[[nodiscard]] Result<GrownRegions> grow_regions(const TriangleMesh& mesh, const Topology& topology,
                                                const ConvexSurface& surface,
                                                const OctreeFrame& root,
                                                const GrownRegionsOptions& options = {});

} // namespace proxima
