// Triangles by eights, as floats: what a proxy's questions are sorted out with.
//
//     group    eight neighbours of the index's order, corners from the group's own
//     centre boxes    of the groups round a place: what is asked for is compared with these first
//     units    lengths times a power of two, so that the surface's extent is 1 to 2
//
// Lanes leave out only what is farther than asked for by more than their rounding, and name the
// rest by rank: to be looked at in doubles.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// Up to eight triangles; places beyond them repeat the last.
struct alignas(64) TriangleGroup {
    static constexpr std::size_t width = 8;
    std::array<std::array<float, width>, 3> corners[3]; ///< of corner, by axis, from the centre
    std::array<double, 3> center = {};                  ///< in the surface's own unit
    float size = 0;                                     ///< no coordinate is larger
    std::uint32_t count = 0;
};

/// Boxes of groups, from the surface's origin, rounded outward.
struct GroupBoxes {
    static constexpr std::size_t capacity = 512;
    std::size_t count = 0; ///< more than there is room for means that some are missing
    std::array<std::uint32_t, capacity> ids = {};
    std::array<std::array<float, capacity>, 3> lower = {};
    std::array<std::array<float, capacity>, 3> upper = {};
};

/// A place and a way from it, zero for a ball, in the surface's own unit.
struct GroupQuery {
    Vec3 origin = Vec3::Zero(); ///< of the boxes
    double scale = 1;           ///< to units
    Vec3 place = Vec3::Zero();
    Vec3 way = Vec3::Zero();
    double distance = 0;
    double rounding = 0; ///< of coordinates and of what is done with the triangles found
};

/// \pre 1 to 8 triangles
[[nodiscard]] TriangleGroup make_group(std::span<const Triangle> triangles, double scale) noexcept;

/// The ranks, eight times a group's number and on, of all triangles of these groups that are within
/// the distance of the place, or of the way if there is one, and of some that are a little farther.
/// With a way, also before which part of it, 0 to 1, nothing of each triangle is so near. Returns
/// how many. 25 ns per group. \pre there is room for eight of each group
[[nodiscard]] std::size_t scan_groups(std::span<const TriangleGroup> groups,
                                      std::span<const std::uint32_t> ids, const GroupQuery& query,
                                      std::span<std::uint32_t> ranks,
                                      std::span<float> times) noexcept;

} // namespace proxima
