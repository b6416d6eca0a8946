// The slow ray caster that the fast ones are held to: it tests every triangle.
#pragma once

#include "geometry/ray_triangle.h"
#include "proxima/cast_ray.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace proxima {

/// All hits in order; none for an invalid ray. O(triangles).
/// \pre positions in use are finite
[[nodiscard]] inline std::vector<RayHit>
all_hits_by_brute_force(const TriangleMesh& mesh, const Ray& ray, Faces faces = Faces::both)
{
    std::vector<RayHit> hits;
    if (!is_valid(ray)) return hits;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const auto hit = intersect(ray, mesh.triangle(TriangleId{id}), faces);
        if (hit) hits.push_back({hit->t, TriangleId{id}, hit->u, hit->v});
    }
    std::ranges::sort(hits, [](const RayHit& a, const RayHit& b) { return a.before(b); });
    return hits;
}

/// The first of all hits.
[[nodiscard]] inline std::optional<RayHit>
closest_hit_by_brute_force(const TriangleMesh& mesh, const Ray& ray, Faces faces = Faces::both)
{
    const std::vector<RayHit> hits = all_hits_by_brute_force(mesh, ray, faces);
    return hits.empty() ? std::nullopt : std::optional(hits.front());
}

} // namespace proxima
