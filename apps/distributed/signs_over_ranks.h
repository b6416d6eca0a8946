// Signed distances from a mesh that is spread over the ranks.
//
//     closest feature     closest_over_ranks.h
//     closed mesh         a ray along x from the point: every rank whose box it meets counts, exactly,
//                         how often it crosses the triangles there outwards less inwards
//     open mesh           every rank bounds the winding number of its triangles, ever more closely
//                         until the sum tells; where rounding would decide, that is an error
//
// A point is inside where the winding number is at least 1/2, as in the library (signed_distance.h).
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
    std::int64_t winding = 0; ///< inside where above 0; not counted where a point is surely outside

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

/// The signed distances of this rank's points, which are finite and have the numbers from `first` on.
/// Error limit_exceeded where the mesh is open and rounding would decide. Collective.
/// \pre the part has winding numbers if the mesh is open
[[nodiscard]] Result<std::vector<SignedOfWhole>> signs_over_ranks(const MeshPart& part,
                                                                  std::span<const Vec3> points,
                                                                  std::uint64_t first,
                                                                  World& world);

} // namespace proxima
