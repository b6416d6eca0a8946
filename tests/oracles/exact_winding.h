// The winding number of a closed mesh, exactly: signed crossings of a line to far away, counted by
// signs of determinants that do not round.
#pragma once

#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <optional>
#include <random>
#include <span>

namespace proxima::oracle {

/// By one line and some triangles; nothing where it touches an edge, a vertex or a triangle's plane
/// from within.
[[nodiscard]] inline std::optional<int> crossings(const TriangleMesh& mesh,
                                                  std::span<const TriangleId> triangles,
                                                  const Vec3& p, const Vec3& far)
{
    int sum = 0;
    for (const TriangleId id : triangles) {
        const Triangle t = mesh.triangle(id);
        if (is_degenerate(t)) continue; // encloses nothing
        const int at_p = orient3d(t[0], t[1], t[2], p);
        const int at_far = orient3d(t[0], t[1], t[2], far);
        if (at_p * at_far > 0) continue;
        const int a = orient3d(p, far, t[0], t[1]);
        const int b = orient3d(p, far, t[1], t[2]);
        const int c = orient3d(p, far, t[2], t[0]);
        if ((a > 0 || b > 0 || c > 0) && (a < 0 || b < 0 || c < 0)) continue;
        if (a == 0 || b == 0 || c == 0 || at_p == 0 || at_far == 0) return std::nullopt;
        sum += at_far; // leaves through the front: it was behind
    }
    return sum;
}

/// By one line and all triangles.
[[nodiscard]] inline std::optional<int> crossings(const TriangleMesh& mesh, const Vec3& p,
                                                  const Vec3& far)
{
    int sum = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const auto one = crossings(mesh, std::array{TriangleId{i}}, p, far);
        if (!one) return std::nullopt;
        sum += *one;
    }
    return sum;
}

/// How often the closed mesh winds round p; nothing if p is on it.
[[nodiscard]] inline std::optional<int> exact_winding(const TriangleMesh& mesh, const Vec3& p)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> part(-1, 1);
    const Box box = bounding_box(mesh);
    const double reach = 4 * (length_of(box.extent()) + length_of(p - box.center()));
    for (int tries = 0; tries < 20; ++tries) {
        const Vec3 toward{part(random), part(random), part(random)};
        if (const auto sum = crossings(mesh, p, p + reach * toward.normalized())) return sum;
    }
    return std::nullopt;
}

} // namespace proxima::oracle
