// Signed distances from a closed mesh that is spread over the ranks.
//
//     closest feature     closest_over_ranks.h
//     winding number      a ray along x from the point: every rank whose box it meets counts, exactly,
//                         how often it crosses the triangles there outwards less inwards; the sum
//
// A point is inside where the winding number is above 0, as in the library (signed_distance.h).
#pragma once

#include "distributed/closest_over_ranks.h"
#include "distributed/mesh_part.h"
#include "distributed/world.h"
#include "proxima/signed_distance.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

struct SignedOfWhole {
    ClosestOfWhole closest;
    std::int64_t winding = 0; ///< not counted on the surface, outside of the box, and endlessly far

    /// In the mesh's unit, negative inside, 0 on the closest feature.
    [[nodiscard]] double signed_distance(double scale) const noexcept
    {
        if (closest.is_on_feature != 0) return 0;
        const double distance = closest.distance(scale);
        return winding > 0 ? -distance : distance;
    }
    [[nodiscard]] SignMethod method() const noexcept
    {
        return closest.is_on_feature != 0 ? SignMethod::on_surface : SignMethod::winding_number;
    }
};

/// Error invalid_mesh where an edge of the mesh does not have as many triangles each way.
[[nodiscard]] Status check_closed(const MeshPart& part);

/// The signed distances of this rank's points, which are finite. Collective. \pre check_closed(part)
[[nodiscard]] Result<std::vector<SignedOfWhole>>
signs_over_ranks(const MeshPart& part, std::span<const Vec3> points, World& world);

} // namespace proxima
