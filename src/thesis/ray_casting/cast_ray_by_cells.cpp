#include "proxima/thesis.h"

#include "geometry/ray_triangle.h"
#include "proxima/cells_along_ray.h"

#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// Values of t are compared across the border of a cell with this part of t, and of what t is for
/// the octree's coordinates, to spare: rounding stays far below it.
constexpr double border_margin = 1e-9;

/// The part of the spare that is the same for all t of a ray.
double margin_of(const Octree& octree, const Ray& ray) noexcept
{
    const Box root = octree.box(octree.root());
    const double reach = root.lower.cwiseAbs().cwiseMax(root.upper.cwiseAbs()).maxCoeff() +
                         ray.origin.cwiseAbs().maxCoeff();
    return border_margin * reach / ray.direction.cwiseAbs().maxCoeff();
}

} // namespace

std::optional<RayHit> closest_hit_by_cells(const Octree& octree, const TriangleMesh& mesh,
                                           const Ray& ray, Faces faces) noexcept
{
    std::optional<RayHit> closest;
    if (!is_valid(ray)) return closest;
    const double margin = margin_of(octree, ray);
    const auto surely_before = [margin](double t, double other) noexcept {
        return t + border_margin * std::abs(t) + margin < other;
    };
    // The whole line: a range may begin or end where the line leaves a cell, and has no stretch in
    // it then.
    Ray line = ray;
    line.t_min = -std::numeric_limits<double>::infinity();
    line.t_max = std::numeric_limits<double>::infinity();
    cells_along_ray(octree, line, [&](const CellOnRay& at) noexcept {
        if (surely_before(at.exit, ray.t_min)) return Flow::proceed;
        if (surely_before(ray.t_max, at.enter)) return Flow::stop;
        for (const TriangleId id : octree.triangles(at.cell)) {
            const auto found = intersect(ray, mesh.triangle(id), faces);
            if (!found) continue;
            const RayHit hit{found->t, id, found->u, found->v};
            if (!closest || hit.before(*closest)) closest = hit;
        }
        return closest && surely_before(closest->t, at.exit) ? Flow::stop : Flow::proceed;
    });
    return closest;
}

} // namespace proxima
