// A search for the closest feature on its way through a mesh index: the ball that is searched, the
// blocks put aside, and the candidates. In units of the index's frame (IndexParts::scale).
#pragma once

#include "index/index_parts.h"
#include "index/triangle_row.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "query/closest/feature_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace proxima {

/// How a search for a point goes.
enum class QueryStart : std::uint8_t {
    near,    ///< in floats
    far,     ///< from where floats tell nothing apart: in doubles (NearWalk)
    endless, ///< squared distances leave the doubles: the first vertex (first_vertex)
    nothing  ///< the point is not finite, or nothing is wanted
};

/// A triangle that may be the closest.
struct RowCandidate {
    float squared; ///< distance as floats have it; 0 where they tell nothing
    std::uint32_t row;
};

/// Not initialised but for begin(): it is made for every query.
struct IndexQuery {
    /// The unit roundoff of floats.
    static constexpr float roundoff = 0x1p-24F;

    /// Points farther from the index's center are for NearWalk: each unit of distance adds to the
    /// rounding of the point, and so to the candidates.
    static constexpr double far = 64;

    // See search_index-inl.h for where these come from; extent is the edge of a leaf's box.
    static constexpr float per_distance = 9 * roundoff;
    static constexpr float per_extent = 368 * roundoff; // 212 times the root of 3, rounded up
    static constexpr float per_foot = 600 * roundoff;
    static constexpr float sliver_radius = 0.035F; // the root of 3 over 50, rounded up

    // Entering a node replaces it by eight at most; eight slots are written at once.
    static constexpr std::size_t most_pending = 7 * IndexParts::max_levels + 1 + 8;

    static constexpr std::uint32_t end = 0xFFFFFFFF; ///< instead of a reference

    std::array<float, 3> p;
    float error;  ///< by which rounding the point and the vertices to floats moves distances
    float reach;  ///< nothing farther is wanted
    float most;   ///< its square, more than boxes' distances are rounded
    float least;  ///< squared distance of the nearest triangle so far, as floats have it
    float extent; ///< the largest of the candidates' leaves
    std::uint32_t next;
    std::uint32_t pending;
    std::uint32_t candidate_count;
    std::array<std::uint32_t, most_pending> references;
    std::array<float, most_pending> nearness; ///< squared, of the references' boxes
    std::array<RowCandidate, 64> candidates;
    RowDistance best;

    // Not in its initialisation, which would clear all.
    IndexQuery() noexcept {} // NOLINT(modernize-use-equals-default)

    /// `known` in the mesh's unit: nothing farther is wanted.
    QueryStart begin(const IndexParts& index, const Vec3& point, double known) noexcept
    {
        const Vec3 at = (point - index.center()) * index.scale();
        const double size = at.cwiseAbs().maxCoeff();
        if (!point.allFinite() || !(known >= 0) || index.triangle_count() == 0)
            return QueryStart::nothing;
        if (!(size <= far)) return size < endless_distance ? QueryStart::far : QueryStart::endless;
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = static_cast<float>(at[static_cast<Eigen::Index>(axis)]);
        const double farthest = farthest_from(size);
        error = rounding_from(size);
        const double wanted = known * index.scale();
        set_reach(static_cast<float>(((wanted < farthest ? wanted : farthest) + 0x1p-38) *
                                     (1 + 0x1p-20)));
        least = std::numeric_limits<float>::infinity();
        extent = 0;
        candidate_count = 0;
        references[0] = end;
        nearness[0] = 0; // never beyond reach
        pending = 1;
        next = index.root();
        best = {};
        return QueryStart::near;
    }

    /// No vertex is farther from a point whose largest coordinate in the frame is `size`.
    [[nodiscard]] static double farthest_from(double size) noexcept
    {
        constexpr double root_3 = 1.7321;
        // Vertices are within 1 of the center, their rounding and that of doubles within 0.01 more.
        return root_3 * (size + 1.01);
    }
    /// By which rounding such a point and the vertices to floats moves distances.
    [[nodiscard]] static float rounding_from(double size) noexcept
    {
        return static_cast<float>(farthest_from(size) * (1 + 0x1p-20)) * roundoff;
    }

    /// Squared distances of triangles beyond this are not wanted.
    [[nodiscard]] float limit(float leaf_extent) const noexcept
    {
        const float size = reach + error_of(reach, leaf_extent);
        return (size * size + foot_error_squared(reach, leaf_extent)) * (1 + 0x1p-20F);
    }
    /// The same for the sides of slivers.
    [[nodiscard]] float sliver_limit(float leaf_extent) const noexcept
    {
        const float size =
            reach + error_of(reach, leaf_extent) + sliver_radius * leaf_extent + 2 * roundoff;
        return size * size * (1 + 0x1p-20F);
    }

    /// Takes a triangle's squared distance for a new end of the search.
    void shrink(float squared, float leaf_extent) noexcept
    {
        if (!(squared < least)) return;
        least = squared;
        const float size = most_distance(squared, leaf_extent);
        if (size < reach) set_reach(size * (1 + 0x1p-20F));
    }
    /// The distance of a triangle whose square floats have so, rounded up.
    [[nodiscard]] float most_distance(float squared, float leaf_extent) const noexcept
    {
        const float distance = std::sqrt(squared);
        return std::sqrt(squared + foot_error_squared(distance, leaf_extent)) +
               error_of(distance, leaf_extent) * (1 + 0x1p-10F);
    }
    /// A lower bound of the distance, whatever the triangle's shape.
    [[nodiscard]] float least_distance(float squared, float leaf_extent) const noexcept
    {
        const float distance = std::sqrt(squared);
        const float foot = per_foot * (distance + 1.7321F * leaf_extent);
        const float off =
            error_of(distance, leaf_extent) + foot + sliver_radius * leaf_extent + 2 * roundoff;
        return std::max(distance - off * (1 + 0x1p-10F), 0.0F);
    }
    /// Takes the best answer for it.
    void shrink_to_best() noexcept
    {
        const auto size = static_cast<float>((std::sqrt(best.squared) + 0x1p-38) * (1 + 0x1p-20));
        if (size < reach) set_reach(size);
    }

private:
    void set_reach(float size) noexcept
    {
        reach = size;
        most = size * size * (1 + 0x1p-16F);
    }
    [[nodiscard]] float error_of(float distance, float leaf_extent) const noexcept
    {
        return error + per_distance * distance + per_extent * leaf_extent;
    }
    [[nodiscard]] static float foot_error_squared(float distance, float leaf_extent) noexcept
    {
        const float foot = per_foot * (distance + 1.7321F * leaf_extent);
        return foot * foot;
    }
};

/// The answer where all features are as far: the first vertex that has a triangle. O(rows)
[[nodiscard]] RowDistance first_vertex(std::span<const TriangleRow<float>> rows) noexcept;
[[nodiscard]] RowDistance first_vertex(std::span<const TriangleRow<double>> rows) noexcept;

} // namespace proxima
