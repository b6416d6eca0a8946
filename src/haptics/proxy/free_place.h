// Where a sphere can begin: the free place nearest to a wanted one.
//
//     free       there itself, if nothing is nearer than the radius
//     pushed     away from the nearest triangle, again and again
//     searched   on shells round it, and from there as near as a slide comes
//
// Of these the nearest that the wanted place sees (a point gets there from it), else the nearest of
// all; none farther than four radii. So one who begins in a crevice begins at its mouth, one who
// begins within a thin wall beside it, and where all is narrow there is no place.
#pragma once

#include "haptics/proxy/slide_sphere.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/geometry.h"

#include <optional>

namespace proxima {

/// No free place is looked for farther than this many radii away.
inline constexpr double free_place_radii = 4;

/// noexcept, no allocation; a question where p is free, else up to 300: 0.2 ms.
/// \pre p is finite, radius >= safety_gap(surface.scale())
[[nodiscard]] std::optional<Vec3> find_free_place(const ContactSurface& surface, double radius,
                                                  const Vec3& p, SlideScratch& scratch) noexcept;

} // namespace proxima
