// The place nearest to a wanted one that several planes allow: what a proxy's contacts leave it.
//
//     minimise |x - q|^2 / 2  where  n_i . x >= d_i     [zilles-1995], at most three planes active
//
// The optimum is where one, two or three of the planes meet, or q: an active set of at most three
// is kept, the plane that is violated most is added, and of all subsets that have it the nearest
// solution that satisfies these planes is taken. Dropping the plane with the most negative
// multiplier instead may end inside of one that was dropped.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// A half-space as the wanted place sees it.
struct ContactPlane {
    Vec3 normal = Vec3::UnitZ(); ///< of length 1, to the allowed side
    double gap = 0;              ///< n . q - d: negative where q is forbidden
};

/// The nearest place allowed.
struct PlaneSolution {
    Vec3 shift = Vec3::Zero();            ///< from q
    std::array<std::uint8_t, 3> active{}; ///< planes that hold it back
    std::array<double, 3> pressure{};     ///< their multipliers: shift = sum pressure n
    std::size_t count = 0;                ///< how many do
    bool feasible = true;                 ///< no plane is violated by more than the tolerance
};

/// No set of planes is larger.
inline constexpr std::size_t max_contact_planes = 128;

/// \pre tolerance > 0, at most max_contact_planes. Planes within 1e-11 of parallel are not
/// combined. noexcept, no allocation; 10 ns for one plane, 0.2 us for three.
[[nodiscard]] PlaneSolution nearest_allowed(std::span<const ContactPlane> planes,
                                            double tolerance) noexcept;

} // namespace proxima
