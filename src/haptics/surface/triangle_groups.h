// Groups of eight triangles as floats, which filter the queries of a proxy.
//
//     group    eight neighbours in the index's order, corners relative to the group's own centre
//     boxes    of the groups near a position: a query is compared with these first
//     units    lengths times a power of two, so that the surface's extent is 1 to 2
//
// The index's rows hold the same corners row by row in the mesh's unit. Groups hold them by lane, and
// relative to a centre so that floats lose little far from the origin: 40 bytes per triangle. When
// each scan made them from the rows instead, the median tick on a dragon of 871,414 triangles took
// 1.3 to 2.5 times as long in three of four scripts and as long in the fourth, which is mostly in
// free space; the slowest of 5,000 ticks took 1.7 to 3.6 times as long. The boxes of groups are the
// leaves of a triangle tree, not copied here.
//
// The lanes drop only triangles that are too far by more than the rounding of floats, and return
// the ranks of the others, which are then tested in doubles.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// Up to eight triangles; lanes beyond them repeat the last one.
struct alignas(64) TriangleGroup {
    static constexpr std::size_t width = 8;
    std::array<std::array<float, width>, 3> corners[3]; ///< by corner and axis, from the centre
    std::array<double, 3> center = {};                  ///< in the surface's own unit
    float size = 0;                                     ///< no coordinate is larger
    std::uint32_t count = 0;
};

/// Boxes of groups, from the surface's origin, rounded outward.
struct GroupBoxes {
    static constexpr std::size_t capacity = 512;
    std::size_t count = 0; ///< more than the capacity: some are missing
    std::array<std::uint32_t, capacity> ids = {};
    std::array<std::array<float, capacity>, 3> lower = {};
    std::array<std::array<float, capacity>, 3> upper = {};
};

/// A position and a motion from it, zero for a ball, in the surface's own unit.
struct GroupQuery {
    Vec3 origin = Vec3::Zero(); ///< of the boxes
    double scale = 1;           ///< to units
    Vec3 position = Vec3::Zero();
    Vec3 motion = Vec3::Zero();
    double distance = 0;
    double rounding = 0; ///< of coordinates, and of later tests of the triangles
};

/// \pre 1 to 8 triangles
[[nodiscard]] TriangleGroup make_group(std::span<const Triangle> triangles, double scale) noexcept;

/// Writes the ranks of all triangles of these groups within the distance of the position, or of the
/// motion if there is one, and of some a little farther. The ranks of a group begin at eight times
/// its id. With a motion it also writes, for each triangle, a part of the motion (0 to 1) before
/// which no point of the triangle is within the distance. Returns the number of ranks. 25 ns per
/// group. \pre ranks and times take eight of each group
[[nodiscard]] std::size_t scan_groups(std::span<const TriangleGroup> groups,
                                      std::span<const std::uint32_t> ids, const GroupQuery& query,
                                      std::span<std::uint32_t> ranks,
                                      std::span<float> times) noexcept;

} // namespace proxima
