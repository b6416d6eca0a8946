// Ways of a point out of a pocket that only the safety gap makes.
//
//     A point proxy is a sphere as thick as the safety gap. Beside a corner with ridges and valleys
//     three faces may hold that sphere, a few gaps above the corner, where a point would go on:
//     between the planes of these faces, along a valley or over a ridge.
//
// From such a corner the steepest way is along one of its faces, or along the line where the planes
// of two meet. These are tried, a little lifted, so that a few gaps farther there is room for the
// sphere again.
#pragma once

#include "haptics/surface/contact_triangle.h"
#include "proxima/geometry.h"

#include <optional>
#include <span>

namespace proxima {

/// In safety gaps.
inline constexpr double corner_size = 16;  ///< how near faces of the corner are
inline constexpr double corner_way = 4096; ///< how long ways are

/// The motion of that length from p whose cosine with the direction `towards`, of length 1, is largest,
/// and larger than `least`, such that it passes no triangle, comes no nearer to any than an eighth
/// of the gap, and ends more than a gap from all. Nothing where there is none, or where the corner
/// has more than 12 faces or 64 triangles about it. noexcept, no allocation.
/// \pre `near` has all triangles within the length and two gaps of p; p is a gap from all
[[nodiscard]] std::optional<Vec3> way_from_corner(std::span<const ContactTriangle> near,
                                                  const Vec3& p, const Vec3& towards, double least,
                                                  double gap) noexcept;

} // namespace proxima
