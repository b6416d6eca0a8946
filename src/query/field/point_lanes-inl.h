// Points of a grid, eight in lanes, against lists of triangles. Included once per target.

#if defined(PROXIMA_QUERY_FIELD_POINT_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_FIELD_POINT_LANES_INL_H
#undef PROXIMA_QUERY_FIELD_POINT_LANES_INL_H
#else
#define PROXIMA_QUERY_FIELD_POINT_LANES_INL_H
#endif

#include "query/closest/search_index-inl.h"
#include "query/field/covered_box-inl.h"
#include "query/field/grid_part.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Points that are searched for together.
inline constexpr std::size_t most_together = 64;

/// One triangle in all lanes.
PROXIMA_LANE_OP EightTriangles in_all_lanes(const TriangleLanes::Group& group, std::size_t lane)
{
    const auto corner = [&](std::size_t k) HWY_ATTR {
        return Eight3{eight(group.corners[k][0][lane]), eight(group.corners[k][1][lane]),
                      eight(group.corners[k][2][lane])};
    };
    return {{corner(0), corner(1), corner(2)}};
}

/// Squared distances beyond which triangles are not the closest.
struct LaneLimits {
    Eight sound;
    Eight slivers;
};

/// Where the nearest triangle is at these squared distances, as floats have them: IndexQuery::shrink and
/// its limits, for eight points.
PROXIMA_STEP LaneLimits limits_of(const Eight& least, float error, float extent)
{
    using Query = IndexQuery;
    const auto error_of = [&](const Eight& distance) HWY_ATTR {
        return multiply_add(distance, eight(Query::per_distance),
                            eight(error + Query::per_extent * extent));
    };
    const auto foot_squared = [&](const Eight& distance) HWY_ATTR {
        const Eight foot = eight(Query::per_foot) * (distance + eight(1.7321F * extent));
        return foot * foot;
    };
    const auto squared = [](const Eight& size) HWY_ATTR { return size * size; };
    const Eight up = eight(1 + 0x1p-19F);
    const Eight distance = square_root(least);
    const Eight reach =
        (square_root(least + foot_squared(distance)) + error_of(distance) * eight(1 + 0x1p-10F)) *
        up;
    const Eight size = reach + error_of(reach);
    return {(squared(size) + foot_squared(reach)) * up,
            squared(size + eight(Query::sliver_radius * extent + 2 * Query::roundoff)) * up};
}

/// Compares the points whose bits are set with a row.
template <class Scalar>
HWY_NOINLINE void offer_row_to(const TriangleRow<Scalar>& row, std::uint32_t rank,
                               const RowScale& scale, std::uint32_t bits, const Vec3* points,
                               RowDistance* found)
{
    for (; bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
        const RowDistance distance = closest_of_row(row, rank, points[lane], scale);
        if (distance.before(found[lane])) found[lane] = distance;
    }
}

/// A triangle that is about the closest of a point.
struct Nearest {
    double least; ///< the point is not nearer to any triangle
    std::size_t triangle;
};

class PointLanes {
public:
    /// Refers to both; `squared` is scratch.
    PointLanes(const IndexParts& index, std::vector<std::array<float, 8>>& squared) noexcept
        : index_(index), squared_(squared)
    {}

    /// Finds the triangles nearest to the middles of eight pieces at once.
    [[nodiscard]] HWY_NOINLINE std::array<Nearest, 8> nearest_to(std::span<const GridPart> pieces,
                                                                 const TriangleLanes& all) const
    {
        HWY_ALIGN float at[3][8];
        double size = 0;
        for (std::size_t i = 0; i < 8; ++i) {
            const GridPart& piece = pieces[std::min(i, pieces.size() - 1)];
            size = std::max(size, set_frame(piece.middle, i, at));
        }
        const Eight3 p{load_eight(at[0]), load_eight(at[1]), load_eight(at[2])};
        Eight least = eight(std::numeric_limits<float>::infinity());
        Eight nearest = eight(0.0F);
        float number = 0; // whole, and far below 2^24
        float extent = 0;
        for (const TriangleLanes::Group& group : all.groups()) {
            extent = std::max(extent, group.extent);
            for (std::uint32_t lane = 0; lane < group.count; ++lane, ++number) {
                const Eight squared = distances_of(in_all_lanes(group, lane), p).squared;
                nearest = choose(squared < least, eight(number), nearest);
                least = minimum(squared, least);
            }
        }
        IndexQuery query;
        query.error = IndexQuery::rounding_from(size);
        HWY_ALIGN float squared[8];
        HWY_ALIGN float numbers[8];
        store_eight(least, squared);
        store_eight(nearest, numbers);
        std::array<Nearest, 8> result;
        for (std::size_t i = 0; i < 8; ++i) {
            result[i] = {query.least_distance(squared[i], extent) * index_.unscale(),
                         static_cast<std::size_t>(numbers[i])};
        }
        return result;
    }

    /// The closest features of points, most_together at most, among these triangles.
    HWY_NOINLINE void search(const TriangleLanes& triangles, std::span<const Vec3> points,
                             RowDistance* found)
    {
        const std::size_t eights = (points.size() + 7) / 8;
        HWY_ALIGN float at[most_together / 8][3][8];
        double size = 0;
        for (std::size_t i = 0; i < 8 * eights; ++i) {
            const Vec3& p = points[std::min(i, points.size() - 1)];
            size = std::max(size, set_frame(p, i % 8, at[i / 8]));
        }
        const float error = IndexQuery::rounding_from(size);
        squared_.resize(8 * triangles.groups().size() * eights);
        HWY_ALIGN float least[most_together / 8][8];
        std::fill_n(&least[0][0], 8 * eights, std::numeric_limits<float>::infinity());
        auto* squared = squared_.data();
        float extent = 0;
        for (const TriangleLanes::Group& group : triangles.groups()) {
            extent = std::max(extent, group.extent);
            for (std::uint32_t lane = 0; lane < group.count; ++lane) {
                const PreparedTriangles triangle = prepare(in_all_lanes(group, lane));
                for (std::size_t i = 0; i < eights; ++i) {
                    const Eight3 p{load_eight(at[i][0]), load_eight(at[i][1]),
                                   load_eight(at[i][2])};
                    const Eight distances = distances_of(triangle, p).squared;
                    store_eight(distances, (squared++)->data());
                    store_eight(minimum(distances, load_eight(least[i])), least[i]);
                }
            }
        }
        Limits limits;
        for (std::size_t i = 0; i < eights; ++i) {
            const LaneLimits own = limits_of(load_eight(least[i]), error, extent);
            store_eight(own.sound, limits.sound[i]);
            store_eight(own.slivers, limits.slivers[i]);
        }
        settle_candidates(triangles, limits, points, found);
    }

private:
    /// By eights of points.
    struct Limits {
        HWY_ALIGN float sound[most_together / 8][8];
        HWY_ALIGN float slivers[most_together / 8][8];
    };

    /// Compares points in doubles with the triangles that are within their limits.
    HWY_INLINE void settle_candidates(const TriangleLanes& triangles, const Limits& limits,
                                      std::span<const Vec3> points, RowDistance* found) const
    {
        const std::size_t eights = (points.size() + 7) / 8;
        const std::uint32_t last_points =
            ~std::uint32_t{0} >> (32 - (points.size() - 8 * (eights - 1)));
        const auto* squared = squared_.data();
        for (const TriangleLanes::Group& group : triangles.groups()) {
            const std::uint32_t slivers = slivers_of(group);
            for (std::uint32_t lane = 0; lane < group.count; ++lane) {
                const auto& most = (slivers >> lane & 1U) != 0 ? limits.slivers : limits.sound;
                for (std::size_t i = 0; i < eights; ++i) {
                    std::uint32_t bits =
                        (load_eight((squared++)->data()) <= load_eight(most[i])).bits();
                    if (i + 1 == eights) bits &= last_points;
                    if (bits != 0) offer(group.rows[lane], bits, &points[8 * i], found + 8 * i);
                }
            }
        }
    }

    [[nodiscard]] static HWY_INLINE std::uint32_t slivers_of(const TriangleLanes::Group& group)
    {
        return ~prepare(triangles_of(group)).sound.bits();
    }

    void offer(std::uint32_t row, std::uint32_t bits, const Vec3* points, RowDistance* found) const
    {
        const RowScale scale = row_scale_of(index_);
        if (index_.double_rows().empty()) {
            offer_row_to(index_.float_rows()[row], row, scale, bits, points, found);
        } else {
            offer_row_to(index_.double_rows()[row], row, scale, bits, points, found);
        }
    }

    /// Sets lane i to a point in the frame. Its largest coordinate.
    HWY_INLINE double set_frame(const Vec3& p, std::size_t i, float (&lanes)[3][8]) const noexcept
    {
        const Vec3 at = (p - index_.center()) * index_.scale();
        for (std::size_t axis = 0; axis < 3; ++axis)
            lanes[axis][i] = static_cast<float>(at[static_cast<Eigen::Index>(axis)]);
        return at.cwiseAbs().maxCoeff();
    }

    const IndexParts& index_;
    std::vector<std::array<float, 8>>& squared_;
};

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
