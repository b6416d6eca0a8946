// Finds the position nearest to a wanted one that the planes of a proxy's contacts allow.
//
//     minimise |x - q|^2 / 2  where  n_i . x >= d_i     [zilles-1995], at most three planes active
//
// The optimum is q or a point in which one, two or three of the planes meet. The solver keeps an
// active set of at most three planes, adds the plane that is violated most, and takes the nearest
// solution among the subsets that contain it. Dropping the plane with the most negative multiplier
// instead may end inside a dropped plane.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// A half-space, relative to the wanted position q.
struct ContactPlane {
    Vec3 normal = Vec3::UnitZ(); ///< of length 1, to the allowed side
    double gap = 0;              ///< n . q - d: negative where q is forbidden
};

/// The nearest position that is allowed.
struct PlaneSolution {
    Vec3 shift = Vec3::Zero();            ///< from q
    std::array<std::uint8_t, 3> active{}; ///< indices of the active planes
    std::array<double, 3> pressure{};     ///< their multipliers: shift = sum pressure n
    std::size_t count = 0;                ///< of active planes
    bool feasible = true;                 ///< no plane is violated by more than the tolerance
};

/// The largest set of planes.
inline constexpr std::size_t max_contact_planes = 128;

/// \pre tolerance > 0, at most max_contact_planes. Planes within 1e-11 of parallel are not
/// combined. noexcept, no allocation; 10 ns for one plane, 0.2 us for three.
[[nodiscard]] PlaneSolution nearest_allowed(std::span<const ContactPlane> planes,
                                            double tolerance) noexcept;

} // namespace proxima
