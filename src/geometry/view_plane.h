// On which side of a view plane a point lies, exactly.
#pragma once

#include "proxima/view_volume.h"

namespace proxima {

/// Sign of normal . point + offset: +1 inside, 0 on the plane, -1 outside. Exact.
/// \pre all finite. Cost: about 2 ns, 0.2 us where the filter fails. Thread safe, no allocation.
[[nodiscard]] int side_of_plane(const ViewPlane& plane, const Vec3& point) noexcept;

/// Sign of plane.normal . x + plane.offset at the point x where three planes meet. Exact.
/// \pre all finite, the normals of the three are linearly independent. Cost: about 0.1 us, some
/// microseconds where the filter fails. Thread safe, no allocation.
[[nodiscard]] int side_of_plane(const ViewPlane& plane, const PlaneMeeting& point) noexcept;

} // namespace proxima
