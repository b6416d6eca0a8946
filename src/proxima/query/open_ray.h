// A ray on its way through a ray index: what the vector code needs of it, in floats.
//
//     p = (o - c) s + t0 d k        the origin in the index's units, moved along the ray to the
//                                   root where it lies outside; k a power of two: 1 <= |d k| < 2
//     t = (t_mesh r - t0)           r = s / k, so that p + t d k is the same point
#pragma once

#include "proxima/geometry/ray.h"
#include "proxima/query/ray_hit.h"
#include "proxima/query/ray_index.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

namespace proxima {

/// Unit roundoff of floats.
inline constexpr float float_roundoff = 0x1p-24F;

/// How far a walk has come.
struct RayPlace {
    std::uint32_t next = 0;    ///< the block to look at
    std::uint32_t pending = 0; ///< how many others are put aside
};

struct OpenRay {
    static constexpr std::uint32_t end = 0xFFFFFFFFU;
    static constexpr std::uint32_t no_row = 0xFFFFFFFFU;
    /// A node makes way for at most eight children; vectors are written whole.
    static constexpr std::size_t stack_size = 7 * RayIndex::max_levels + 1 + 8;

    // For boxes.
    std::array<float, 3> origin;
    std::array<float, 3> inverse; ///< of the direction, whose components are put away from zero
    float least;                  ///< the range, outward; `most` sinks as hits are found
    float most;
    float slack;          ///< that t of planes may be off beyond the boxes' margins
    std::uint32_t octant; ///< bit k: the direction is negative on axis k
    std::array<std::uint32_t, 3>
        near_planes; ///< how to put a node's planes in order, by axis: bytes
    std::array<std::uint32_t, 3> far_planes; ///< into PlaneShuffles

    // For triangles: x, y, z are the axes in cyclic order, z the direction's largest component.
    std::array<std::uint32_t, 3> axes;
    float slope_x;
    float slope_y;
    float inverse_z;
    float error;      ///< factor of weights' errors for a moved origin
    float t_error;    ///< of t, beside what weights' errors do
    float sure_least; ///< t between these are surely in range
    float sure_most;
    bool refuses_positive; ///< weights of this sign are of faces not asked for
    bool refuses_negative;

    // What was found.
    float best_least = std::numeric_limits<float>::infinity(); ///< the best hit's t is not below
    std::uint32_t best_row = no_row; ///< surely hit, not yet computed; then `best` is older
    bool found = false;              ///< `best` is a hit
    RayHit best;

    RayPlace at;
    std::uint32_t place = 0; ///< of the ray in its batch
    const Ray* ray = nullptr;
    Faces faces = Faces::both;
    double rate = 1;  ///< r
    double shift = 0; ///< t0
    std::array<std::uint32_t, stack_size> references;
    std::array<float, stack_size> nearness; ///< t at which the box is entered
};

/// What open_ray says.
enum class RayStart : std::uint8_t {
    misses,  ///< the root: no hit
    ready,   ///< to be walked
    too_far, ///< beyond what floats can sort out: every triangle must be asked
};

/// Sets everything up. The ray must outlive `open`.
[[nodiscard]] RayStart open_ray(const RayIndex& index, const Ray& ray, Faces faces,
                                OpenRay& open) noexcept;

/// Asks a triangle of the index in doubles.
[[nodiscard]] std::optional<RayHit> ask_row(const RayIndex& index, std::uint32_t row,
                                            const Ray& ray, Faces faces) noexcept;
[[nodiscard]] inline std::optional<RayHit> ask_row(const RayIndex& index, std::uint32_t row,
                                                   const OpenRay& open) noexcept
{
    return ask_row(index, row, *open.ray, open.faces);
}

/// Where a triangle's row lies, to have it fetched.
[[nodiscard]] inline const void* row_address(const RayIndex& index, std::uint32_t row) noexcept
{
    if (index.double_rows().empty()) return &index.float_rows()[row];
    return &index.double_rows()[row];
}

} // namespace proxima
