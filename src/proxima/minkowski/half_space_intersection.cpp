#include "proxima/minkowski/half_space_intersection.h"

#include "proxima/minkowski/convex_hull.h"
#include "proxima/minkowski/quickhull.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace proxima {
namespace {

using Vec4 = Eigen::Vector4d;

struct Ball {
    Vec3 center;
    double radius; ///< negative: how far the half-spaces are from having a point in common
};

/// The largest ball in the half-spaces and in a big tetrahedron about the origin: maximise r with
/// n_i . c + r <= d_i, by the simplex method on the dual, whose basis is the four planes touched.
std::optional<Ball> largest_ball(std::vector<HalfSpace> planes, double reach)
{
    const auto auxiliary = planes.size();
    for (int axis = 0; axis < 3; ++axis) planes.push_back({Vec3::Unit(axis), reach});
    planes.push_back({-Vec3::Ones() / std::sqrt(3.0), reach});
    std::array<std::size_t, 4> basis = {auxiliary, auxiliary + 1, auxiliary + 2, auxiliary + 3};

    constexpr int max_steps = 10000;
    for (int step = 0; step < max_steps; ++step) {
        Eigen::Matrix4d touched; // rows (n, 1)
        Vec4 offsets;
        for (int row = 0; row < 4; ++row) {
            const HalfSpace& plane = planes[basis[static_cast<std::size_t>(row)]];
            touched.row(row) << plane.normal.transpose(), 1.0;
            offsets[row] = plane.offset;
        }
        const Eigen::FullPivLU<Eigen::Matrix4d> solver(touched);
        const Vec4 solution = solver.solve(offsets);
        const Ball ball = {solution.head<3>(), solution[3]};

        // The plane that cuts deepest into the ball comes in; on long runs the first that cuts, so
        // that no set of planes comes again [bland-1977].
        std::size_t entering = planes.size();
        double deepest = 1e-12 * reach;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            const double cut = planes[i].normal.dot(ball.center) + ball.radius - planes[i].offset;
            if (cut <= deepest) continue;
            entering = i;
            if (step > max_steps / 2) break;
            deepest = cut;
        }
        if (entering == planes.size()) return ball;

        // Its (n, 1) as a combination of those touched: the one it drives to zero first goes out.
        Vec4 column;
        column << planes[entering].normal, 1.0;
        Vec4 unit;
        unit << 0, 0, 0, 1;
        const Eigen::Matrix4d transposed = touched.transpose();
        const Eigen::FullPivLU<Eigen::Matrix4d> weights_of(transposed);
        const Vec4 weights = weights_of.solve(unit);
        const Vec4 change = weights_of.solve(column);
        int leaving = -1;
        double smallest = std::numeric_limits<double>::infinity();
        for (int row = 0; row < 4; ++row) {
            if (change[row] <= 1e-14) continue;
            const double ratio = std::max(weights[row], 0.0) / change[row];
            if (ratio < smallest) {
                smallest = ratio;
                leaving = row;
            }
        }
        if (leaving < 0) return std::nullopt;
        basis[static_cast<std::size_t>(leaving)] = entering;
    }
    return std::nullopt;
}

/// Leaves one of vectors that are closer than a distance.
void merge_close(std::vector<Vec3>& vectors, double distance)
{
    std::ranges::sort(vectors, [](const Vec3& p, const Vec3& q) {
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    });
    std::vector<Vec3> kept;
    for (const Vec3& v : vectors) {
        bool is_new = true;
        for (auto other = kept.rbegin(); other != kept.rend(); ++other) {
            if (v.x() - other->x() > distance) break;
            if ((v - *other).cwiseAbs().maxCoeff() <= distance) {
                is_new = false;
                break;
            }
        }
        if (is_new) kept.push_back(v);
    }
    vectors = std::move(kept);
}

Result<std::vector<HalfSpace>> normalised(std::span<const HalfSpace> planes)
{
    std::vector<HalfSpace> result;
    result.reserve(planes.size());
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const std::string where = "half-space " + std::to_string(i);
        if (!planes[i].normal.allFinite() || !std::isfinite(planes[i].offset)) {
            return fail(ErrorCode::invalid_argument, "a number is NaN or infinite", where);
        }
        const double length = planes[i].normal.stableNorm();
        if (!(length > 0)) {
            return fail(ErrorCode::invalid_argument, "its normal has no length", where);
        }
        result.push_back({planes[i].normal / length, planes[i].offset / length});
    }
    return result;
}

} // namespace

Result<ConvexPolyhedron> polyhedron_of_half_spaces(std::span<const HalfSpace> given)
{
    const auto planes = normalised(given);
    if (!planes) return tl::unexpected(planes.error());
    double size = 0;
    for (const HalfSpace& plane : *planes) size = std::max(size, std::abs(plane.offset));
    if (size == 0) size = 1;
    std::optional<Ball> ball;
    for (double reach = 16 * size; reach < 1e10 * size; reach *= 1e3) {
        ball = largest_ball(*planes, reach);
        if (ball && ball->radius > 1e-9 * size) break;
    }
    if (!ball || !(ball->radius > 1e-12 * size)) {
        return fail(ErrorCode::invalid_argument,
                    "the half-spaces have no volume in common: none at all, or a flat set");
    }

    // The origin stands for the plane at infinity.
    std::vector<Vec3> duals = {Vec3::Zero()};
    for (const HalfSpace& plane : *planes)
        duals.emplace_back(plane.normal / (plane.offset - plane.normal.dot(ball->center)));
    const detail::HullVertices vertices = {duals, static_cast<std::uint32_t>(duals.size())};
    const detail::AffineSpan span = detail::affine_span(vertices);
    const auto holds_line = [] {
        return fail(ErrorCode::invalid_argument,
                    "the half-spaces have a whole line in common: add planes that end it");
    };
    if (span.dimension < 3) return holds_line();
    const auto triangles = detail::quickhull(vertices, span, nullptr);
    if (!triangles) return tl::unexpected(triangles.error());
    std::vector<Vec3> points;
    std::vector<Vec3> rays;
    for (const detail::HullTriangle& triangle : *triangles) {
        const auto& corner = triangle.vertices;
        const Vec3 p = duals[corner[0]];
        const Vec3 normal = unit_normal({p, duals[corner[1]]}, {p, duals[corner[2]]});
        const double offset = normal.dot(p);
        const double far = std::max({p.norm(), duals[corner[1]].norm(), duals[corner[2]].norm()});
        if (offset <= 1e-13 * far) {
            rays.push_back(normal);
        } else {
            points.emplace_back(normal / offset);
        }
    }
    if (points.empty()) return holds_line();
    double extent = 0;
    for (const Vec3& point : points) extent = std::max(extent, point.cwiseAbs().maxCoeff());
    merge_close(points, 1e-12 * extent);
    merge_close(rays, 1e-9);
    for (Vec3& point : points) point += ball->center;
    return convex_hull(points, rays);
}

} // namespace proxima
