#include "query/rays/brute_force.h"

#include "geometry/ray_triangle.h"

#include <algorithm>

namespace proxima {

namespace {

/// Calls visit(hit) for every hit in the order of ids, until it returns false.
template <class Visit>
void visit_hits(const TriangleMesh& mesh, const Ray& ray, Faces faces, const Visit& visit)
{
    if (!is_valid(ray)) return;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const auto hit = intersect(ray, mesh.triangle(TriangleId{id}), faces);
        if (hit && !visit(RayHit{hit->t, TriangleId{id}, hit->u, hit->v})) return;
    }
}

} // namespace

std::optional<RayHit> closest_hit_by_brute_force(const TriangleMesh& mesh, const Ray& ray,
                                                 Faces faces) noexcept
{
    std::optional<RayHit> closest;
    visit_hits(mesh, ray, faces, [&](const RayHit& hit) noexcept {
        if (!closest || hit.before(*closest)) closest = hit;
        return true;
    });
    return closest;
}

bool any_hit_by_brute_force(const TriangleMesh& mesh, const Ray& ray, Faces faces) noexcept
{
    bool found = false;
    visit_hits(mesh, ray, faces, [&](const RayHit& /*hit*/) noexcept {
        found = true;
        return false;
    });
    return found;
}

std::vector<RayHit> all_hits_by_brute_force(const TriangleMesh& mesh, const Ray& ray, Faces faces)
{
    std::vector<RayHit> hits;
    visit_hits(mesh, ray, faces, [&](const RayHit& hit) {
        hits.push_back(hit);
        return true;
    });
    std::ranges::sort(hits, [](const RayHit& a, const RayHit& b) { return a.before(b); });
    return hits;
}

} // namespace proxima
