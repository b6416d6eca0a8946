// A ray on its way through a mesh index: what the vector code needs of it, in floats.
//
//     p = (o - c) s + t0 d k        the origin in the index's units, moved along the ray to where its
//                                   range begins within the root's box; k a power of two: 1 <= |d k| < 2
//     t = (t_mesh r - t0)           r = s / k, so that p + t d k is the same point; what is looked for
//                                   has 0 <= t <= `most`
#pragma once

#include "geometry/ray_triangle.h"
#include "index/index_parts.h"
#include "proxima/cast_ray.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace proxima {

/// Unit roundoff of floats.
inline constexpr float float_roundoff = 0x1p-24F;

/// A float below the value, and one above, by little; infinity where that is.
[[nodiscard]] inline float rounded_down(double value) noexcept
{
    const auto nearest = static_cast<float>(value);
    return nearest - std::min(std::abs(nearest), 0x1p100F) * 0x1p-23F;
}
[[nodiscard]] inline float rounded_up(double value) noexcept
{
    return -rounded_down(-value);
}

/// How far a walk has come.
struct WalkState {
    std::uint32_t next = 0;    ///< the block to look at
    std::uint32_t pending = 0; ///< the end of those put aside
};

/// A triangle of a mesh index.
struct RayTriangle {
    static constexpr std::uint32_t no_leaf = 0xFFFFFFFFU;
    std::uint32_t leaf = 0; ///< its block
    std::uint32_t lane = 0;
};

/// One number in all lanes of a vector.
struct alignas(32) RayLanes {
    float lanes[8];

    void fill(float value) noexcept { std::fill_n(lanes, 8, value); }
};

/// What a search for hits knows of a ray.
struct SearchedRay {
    float most;             ///< end of the range, outward: sinks as hits are found
    float t_error;          ///< of t, beside what weights' errors do
    float best_least;       ///< the best hit's t is not below
    bool found;             ///< `best` is a hit
    RayTriangle best_noted; ///< surely hit, not yet computed; then `best` is older
    std::uint32_t number;   ///< of the ray in its batch
    const Ray* ray;
    Faces faces;
    double rate;  ///< r
    double shift; ///< t0
    RayShear shear;
    RayHit best;
};

struct RayTraversal : SearchedRay {
    /// Where all is seen: the empty leaf, which no box leads to.
    static constexpr std::uint32_t end = index_leaf_bit;
    /// Below what is put aside: as many ends as are looked at together.
    static constexpr std::uint32_t bottom = 8;
    /// A node makes way for at most eight children; vectors are written whole.
    static constexpr std::size_t stack_size = bottom + 7 * IndexParts::max_levels + 1 + 8;

    /// All is within that.
    static constexpr double cube_reach = 1.01;
    /// A component below 2^-40 moves the ray by less than 2^-37 within the root.
    static constexpr double most_inverse = 0x1p40;
    /// Moving an origin from nearer costs at most a float's half ulp.
    static constexpr double far = 0x1p26;

    // For boxes.
    std::array<RayLanes, 3> inverse; ///< of the direction, its components put away from zero
    std::array<RayLanes, 3> start;   ///< - origin * inverse
    std::uint32_t octant;            ///< bit k: the direction is negative on axis k

    // For triangles: x, y, z are the axes in cyclic order, z the direction's largest component.
    std::array<std::uint32_t, 3> axes;
    std::array<float, 3> origin; ///< on these
    float slope_x;
    float slope_y;
    float inverse_z;
    float error;      ///< factor of weights' errors for a moved origin
    float sure_least; ///< t between these are surely in range
    float sure_most;
    bool refuses_positive; ///< weights of this sign are of faces not asked for
    bool refuses_negative;

    WalkState at;
    std::array<std::uint32_t, stack_size> references;
    std::array<float, stack_size> nearness; ///< t at which the box is entered

    /// What was worked out in doubles.
    struct Range {
        double rate = 1;
        double most = 0;  ///< of t in the root
        double shift = 0; ///< t0
        double moved = 0; ///< how far off the origin is for having been moved
        double t_off = 0; ///< and t

        /// Sets `shift` and `most` by the part of a range between where the ray enters the root's box
        /// and leaves it, with what rounding may do to a hit's t. False where nothing is left.
        bool clip(double own_least, double own_most, double enters, double leaves) noexcept
        {
            const double slack = 160.0 * float_roundoff + 8 * t_off;
            shift = std::max(own_least - slack, enters);
            most = std::min(own_most + slack, leaves);
            return shift <= most;
        }
        /// Where t was counted from `by`.
        void move_by(double by) noexcept
        {
            shift += by;
            most += by;
        }
    };
    /// Sets all but what is for boxes and for triangles, these including `t_error`.
    void set_range(const IndexParts& index, const Ray& own, Faces wanted,
                   const Range& range) noexcept
    {
        const float growth = 1 + static_cast<float>(range.moved) / (8 * float_roundoff);
        error = growth * growth;
        t_error = 40 * float_roundoff + 2 * static_cast<float>(range.t_off);
        most = rounded_up(range.most - range.shift) + 4 * t_error;
        sure_least = rounded_up(own.t_min * range.rate - range.shift) + t_error;
        sure_most = rounded_down(own.t_max * range.rate - range.shift) - t_error;
        // Weights are positive where direction . normal has the sign of the direction's z.
        const bool forward = shear.inverse_z > 0;
        refuses_positive =
            (wanted == Faces::front && forward) || (wanted == Faces::back && !forward);
        refuses_negative =
            (wanted == Faces::front && !forward) || (wanted == Faces::back && forward);
        found = false;
        best_least = std::numeric_limits<float>::infinity();
        best_noted = {RayTriangle::no_leaf, 0};
        ray = &own;
        faces = wanted;
        rate = range.rate;
        shift = range.shift;
        for (std::size_t i = 0; i < RayTraversal::bottom; ++i) {
            references[i] = RayTraversal::end;
            nearness[i] = -std::numeric_limits<float>::infinity();
        }
        at = {index.root(), RayTraversal::bottom};
    }
};

/// k of a ray and what follows of it, by the bits of an exponent.
struct RayUnit {
    static constexpr std::uint64_t exponent_bits = 0x7FF0000000000000U;
    static constexpr std::uint64_t inverting = 0x7FE0000000000000U; ///< less those of x: of 1 / x

    double unscale; ///< 1 / k
    double scale;   ///< k
    double rate;    ///< r

    /// `largest` is the size of the direction's largest component.
    RayUnit(const IndexParts& index, double largest) noexcept
    {
        const std::uint64_t exponent = std::bit_cast<std::uint64_t>(largest) & exponent_bits;
        unscale = std::bit_cast<double>(exponent);
        scale = std::bit_cast<double>(inverting - exponent);
        rate = index.scale() * unscale;
    }

    /// Whether products of them stay normal numbers.
    [[nodiscard]] bool is_ordinary() const noexcept
    {
        return unscale > least && unscale < most && rate > least && rate < most;
    }
    static constexpr double least = 0x1p-1000;
    static constexpr double most = 0x1p1000;

    /// And quotients by the direction's components, those put away from zero by least_component.
    [[nodiscard]] bool is_near_one() const noexcept
    {
        return unscale > 0x1p-400 && unscale < 0x1p400 && rate > least && rate < most;
    }
    static constexpr double least_component = 0x1p-1000;
};

/// What prepare_ray says.
enum class RayStart : std::uint8_t {
    invalid, ///< the ray, see is_valid
    misses,  ///< the root: no hit
    ready,   ///< to be walked
    too_far, ///< beyond what floats can sort out: every triangle must be asked
};

/// The rays of a batch, and who takes what comes of them.
struct RaySource {
    static constexpr std::size_t most_rays = 2048;

    std::span<const Ray> rays;
    Faces faces = Faces::both;
    /// The ray's walk has ended: with this hit, or without one.
    void (*answer)(void* context, std::uint32_t number, const RayHit* hit) = nullptr;
    /// There is no walk: the ray is not `ready`.
    void (*refuse)(void* context, std::uint32_t number, RayStart start) = nullptr;
    void* context = nullptr;
};

/// Sets everything up. The ray must outlive `open`.
[[nodiscard]] RayStart prepare_ray(const IndexParts& index, const Ray& ray, Faces faces,
                                   RayTraversal& open) noexcept;

/// Asks a triangle of the index in doubles. Where there is no hit, `hit` stays as it is.
[[nodiscard]] bool intersect_exact(const IndexParts& index, RayTriangle triangle,
                                   const SearchedRay& searched, RayHit& hit) noexcept;

/// The same for rays that are not open.
[[nodiscard]] std::optional<RayHit> ask_row(const IndexParts& index, std::uint32_t row,
                                            const Ray& ray, Faces faces) noexcept;

/// Where what intersect_exact has yet to read of a triangle lies, to have it fetched.
[[nodiscard]] inline const void* row_address(const IndexParts& index, std::uint32_t row) noexcept
{
    if (index.has_exact_leaves()) return &index.ids()[row];
    if (index.double_rows().empty()) return &index.float_rows()[row];
    return &index.double_rows()[row];
}

} // namespace proxima
