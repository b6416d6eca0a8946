// Two surfaces, one of which is measured from the other: what both deviations begin with.
//
// Lengths are in units of 2^exponent. Where coordinates are near 1, that is 1 and the indexes are the
// caller's; else copies are made whose coordinates are, so that products stay within the doubles.
//
// Rounding, with D the diagonal of the box about both and M the largest coordinate:
//
//     a distance as searched for     512 roundings of D at most (error_bounds.md)
//     a corner after n cuts          n times 2 roundings of M and 2 of D off its triangle
//
// Together below rounding(n) = 2^-44 D + 2^-51 (n + 1) (M + D).
#pragma once

#include "geometry/closest_point.h"
#include "index/index_parts.h"
#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace proxima {

/// The row of B that is closest to a point, and its distance.
struct NearestRow {
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t row = 0;
};

class PROXIMA_HIDDEN SurfacePair {
public:
    /// Errors: invalid_mesh, budget_exceeded, cancelled.
    [[nodiscard]] static Result<SurfacePair> make(const MeshIndex& a, const MeshIndex& b,
                                                  const Execution& execution);

    /// What measuring the vertices of A and bounding its triangles takes.
    [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_of(a_); }

    [[nodiscard]] const IndexParts& a() const noexcept { return a_.parts(); }
    [[nodiscard]] const IndexParts& b() const noexcept { return b_.parts(); }
    /// Of the box about both, in units.
    [[nodiscard]] double diagonal() const noexcept { return diagonal_; }
    [[nodiscard]] double rounding(std::uint32_t cuts) const noexcept
    {
        return 0x1p-44 * diagonal_ + 0x1p-51 * (cuts + 1.0) * (reach_ + diagonal_);
    }

    /// How far the way from a point's foot on a row of B may be off.
    [[nodiscard]] double way_rounding() const noexcept
    {
        return 0x1p-44 * diagonal_ + 0x1p-51 * reach_;
    }
    /// Whether the units have all bits of the callers' coordinates: none became 0 or subnormal.
    [[nodiscard]] bool is_exact() const noexcept { return is_exact_; }

    /// From the meshes' unit, and back to it.
    [[nodiscard]] double to_units(double length) const noexcept;
    [[nodiscard]] double from_units(double length) const noexcept;
    /// Outward, where the unit's doubles are too coarse or end.
    [[nodiscard]] DistanceBounds from_units(const DistanceBounds& bounds) const noexcept;
    [[nodiscard]] Vec3 from_units(const Vec3& point) const noexcept;
    [[nodiscard]] double area_from_units(double area) const noexcept;
    /// How far area_from_units(area) is from the truth at most, where `area` is by `error`: infinitely
    /// where it is infinite.
    [[nodiscard]] double area_error_from_units(double area, double error) const noexcept;

    /// Nothing farther than `known` is there, up to rounding.
    [[nodiscard]] NearestRow nearest(const Vec3& p, double known) const noexcept;

    /// The distance of a point from one row of B: no less than that of B, up to rounding.
    [[nodiscard]] double distance(const Vec3& p, std::uint32_t row) const noexcept
    {
        return (closest_point(b().triangle(row), p).point - p).norm();
    }

private:
    SurfacePair(const MeshIndex& a, const MeshIndex& b) noexcept : a_(a), b_(b) {}
    static std::uint64_t bytes_of(const MeshIndex& a) noexcept;
    void measure() noexcept;
    [[nodiscard]] Status scale(const Execution& execution);

    MeshIndex a_;
    MeshIndex b_;
    int exponent_ = 0;
    bool is_exact_ = true;
    double diagonal_ = 0;
    double reach_ = 0; ///< the largest coordinate
};

/// So many threads, or `most` if that is less, but at least one.
[[nodiscard]] Threads at_most(Threads threads, std::uint64_t most) noexcept;

/// A's vertices by id, with what of B is closest to each.
struct MeasuredVertices {
    std::vector<NearestRow> nearest;

    /// Those of a row of A.
    [[nodiscard]] std::array<NearestRow, 3> of_row(const IndexParts& a,
                                                   std::uint32_t row) const noexcept;
};

/// Stage "distances of vertices". Error: cancelled.
[[nodiscard]] Result<MeasuredVertices> measure_vertices(const SurfacePair& pair,
                                                        const Execution& execution);

} // namespace proxima
