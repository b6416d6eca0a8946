#include "proxima/thesis.h"

#include "geometry/ray_triangle.h"
#include "proxima/cells_along_ray.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
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

/// Where a line enters a box by its planes, and where it leaves it: later, if it only touches the
/// border as rounding has it, or misses. Nothing where it stays beside the box.
struct LineStretch {
    double enter = -std::numeric_limits<double>::infinity();
    double exit = std::numeric_limits<double>::infinity();
};
std::optional<LineStretch> stretch_in(const Box& box, const Ray& line) noexcept
{
    LineStretch stretch;
    for (int axis = 0; axis < 3; ++axis) {
        const double o = line.origin[axis];
        const double d = line.direction[axis];
        if (d == 0 && (o < box.lower[axis] || o > box.upper[axis])) return std::nullopt;
        if (d == 0) continue;
        const double one = (box.lower[axis] - o) / d;
        const double other = (box.upper[axis] - o) / d;
        stretch.enter = std::max(stretch.enter, std::min(one, other));
        stretch.exit = std::min(stretch.exit, std::max(one, other));
    }
    return stretch;
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
    const auto ask = [&](TriangleId id) noexcept {
        const auto found = intersect(ray, mesh.triangle(id), faces);
        if (!found) return;
        const RayHit hit{found->t, id, found->u, found->v};
        if (!closest || hit.before(*closest)) closest = hit;
    };
    bool has_cells = false;
    cells_along_ray(octree, line, [&](const CellOnRay& at) noexcept {
        has_cells = true;
        if (surely_before(at.exit, ray.t_min)) return Flow::proceed;
        if (surely_before(ray.t_max, at.enter)) return Flow::stop;
        for (const TriangleId id : octree.triangles(at.cell)) ask(id);
        return closest && surely_before(closest->t, at.exit) ? Flow::stop : Flow::proceed;
    });
    if (has_cells) return closest;
    // A line that only touches the root has no stretch in any cell, and may hit all the same.
    const auto stretch = stretch_in(octree.box(octree.root()), ray);
    if (!stretch || surely_before(stretch->exit, stretch->enter)) return closest;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) ask(TriangleId{id});
    return closest;
}

} // namespace proxima
