// What every search for hits of a ray answers (thesis section 5.3).
//
//     hit     the first point of a closed triangle on the ray: one per triangle
//     order   by t as computed in doubles, then by triangle id; geometry/ray_triangle.h says how t
//             is computed, and every search computes it there
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

/// P = (1 - u - v) v0 + u v1 + v v2 = origin + t direction.
struct RayHit {
    double t = 0;
    TriangleId triangle{};
    double u = 0;
    double v = 0;
    friend bool operator==(const RayHit&, const RayHit&) = default;

    /// Whether it comes before another hit of its ray.
    [[nodiscard]] bool before(const RayHit& other) const noexcept
    {
        return t < other.t || (t == other.t && triangle < other.triangle);
    }
};

} // namespace proxima
