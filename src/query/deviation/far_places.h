// All places of A that are about as far from B as any.
#pragma once

#include "proxima/execution.h"
#include "query/deviation/near_pieces.h"
#include "query/deviation/surface_pair.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A point of A, and what of B is closest to it.
struct FarPoint {
    Vec3 point = Vec3::Zero();
    NearestRow nearest;
    std::uint32_t row_a = 0;
};

/// The far point in the meshes' own unit, with the point of B closest to it.
[[nodiscard]] FarPlace far_place(const SurfacePair& pair, const FarPoint& far) noexcept;

struct FarPointLimits {
    double enough = 0;  ///< points as far as this may be named
    double certain = 0; ///< those as far as this must have one of them near
    double spacing = 0; ///< between two of them
    std::uint32_t most_points = 0;
    std::uint64_t most_splits = 0; ///< of a triangle
    double tolerance = 0;
};

/// Points that stand for all of a surface.
struct FarPoints {
    std::vector<FarPoint> points;
    bool are_all = true;
    std::uint64_t splits = 0;

    /// Adds a point unless another one is within `spacing` or there are too many.
    void offer(const FarPoint& point, const FarPointLimits& limits);
    /// Whether the whole part is near to one of them.
    [[nodiscard]] bool cover(const std::array<Vec3, 3>& corners, double spacing) const noexcept;
};

/// Of these rows of A, whose points may be as far as limits.certain; `first` is named in any case. The
/// farthest come first. Every point that is as far as limits.certain is within three times the spacing
/// of one of them if are_all. Stage "places that are as far". Error: cancelled.
[[nodiscard]] Result<FarPoints> far_points(const SurfacePair& pair,
                                           const MeasuredVertices& vertices,
                                           std::span<const std::uint32_t> rows,
                                           const FarPoint& first, const FarPointLimits& limits,
                                           const Execution& execution);

} // namespace proxima
