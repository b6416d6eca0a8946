#include "proxima/convex_polyhedron.h"

#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "minkowski/quickhull.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace proxima {
namespace {

// Extended precision where the platform has it; the final check knows whether it was enough.
using Real = long double;
using Real3 = Eigen::Matrix<Real, 3, 1>;
using Real4 = Eigen::Matrix<Real, 4, 1>;
using Real33 = Eigen::Matrix<Real, 3, 3>;
using Real44 = Eigen::Matrix<Real, 4, 4>;

/// normal . x <= offset with a normal of length 1.
struct Plane {
    Real3 normal;
    Real offset;
};

struct Ball {
    Real3 center;
    Real radius; ///< negative: how far the half-spaces are from having a point in common
};

/// The largest ball in the half-spaces and in a big tetrahedron about the origin: maximise r with
/// n_i . c + r <= d_i, by the simplex method on the dual, whose basis is the four planes touched.
std::optional<Ball> largest_ball(std::vector<Plane> planes, Real reach, Progress* progress)
{
    const auto auxiliary = planes.size();
    for (int axis = 0; axis < 3; ++axis) planes.push_back({Real3::Unit(axis), reach});
    planes.push_back({-Real3::Ones().normalized(), reach});
    std::array<std::size_t, 4> basis = {auxiliary, auxiliary + 1, auxiliary + 2, auxiliary + 3};

    constexpr int max_steps = 10000;
    for (int step = 0; step < max_steps; ++step) {
        if (is_cancelled(progress)) return std::nullopt;
        Real44 touched; // rows (n, 1)
        Real4 offsets;
        for (int row = 0; row < 4; ++row) {
            const Plane& plane = planes[basis[static_cast<std::size_t>(row)]];
            touched.row(row) << plane.normal.transpose(), Real(1);
            offsets[row] = plane.offset;
        }
        const Eigen::FullPivLU<Real44> solver(touched);
        const Real4 solution = solver.solve(offsets);
        const Ball ball = {Real3(solution.head<3>()), solution[3]};

        // The plane that cuts deepest into the ball enters the basis. On long runs the first plane
        // that cuts enters, so that no basis repeats [bland-1977].
        std::size_t entering = planes.size();
        Real deepest = 1e-15L * reach;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            const Real cut = planes[i].normal.dot(ball.center) + ball.radius - planes[i].offset;
            if (cut <= deepest) continue;
            entering = i;
            if (step > max_steps / 2) break;
            deepest = cut;
        }
        if (entering == planes.size()) return ball;

        // Writes its (n, 1) as a combination of the touched planes. The first one that becomes zero
        // leaves the basis.
        Real4 column;
        column << planes[entering].normal, Real(1);
        Real4 unit;
        unit << 0, 0, 0, 1;
        const Real44 transposed = touched.transpose();
        const Eigen::FullPivLU<Real44> weights_of(transposed);
        const Real4 weights = weights_of.solve(unit);
        const Real4 change = weights_of.solve(column);
        int leaving = -1;
        Real smallest = std::numeric_limits<Real>::infinity();
        for (int row = 0; row < 4; ++row) {
            if (change[row] <= 1e-14L) continue;
            const Real ratio = std::max(weights[row], Real(0)) / change[row];
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

/// Keeps one of the vectors that are closer than a distance.
void merge_close(std::vector<Vec3>& vectors, double distance)
{
    std::ranges::sort(vectors, [](const Vec3& p, const Vec3& q) {
        return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    });
    std::vector<Vec3> kept;
    for (const Vec3& v : vectors) {
        bool is_new = true;
        for (std::size_t i = kept.size(); i-- > 0;) {
            if (v.x() - kept[i].x() > distance) break;
            if ((v - kept[i]).cwiseAbs().maxCoeff() <= distance) {
                is_new = false;
                break;
            }
        }
        if (is_new) kept.push_back(v);
    }
    vectors = std::move(kept);
}

/// The planes with normals of length 1, and offsets in units of a power of two.
struct ScaledPlanes {
    std::vector<Plane> planes;
    int exponent = 0; ///< the largest offset is 1 to 2 units of 2^exponent
};

Result<ScaledPlanes> normalised(std::span<const HalfSpace> given)
{
    ScaledPlanes result;
    result.planes.reserve(given.size());
    Real size = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
        const std::string where = "half-space " + std::to_string(i);
        if (!given[i].normal.allFinite() || !std::isfinite(given[i].offset)) {
            return fail(ErrorCode::invalid_argument, "a number is NaN or infinite", where);
        }
        const Real3 normal = given[i].normal.cast<Real>();
        const Real length = normal.stableNorm();
        if (!(length > 0)) {
            return fail(ErrorCode::invalid_argument, "its normal has no length", where);
        }
        const Real offset = given[i].offset / length;
        if (!std::isfinite(length) || !(std::abs(offset) <= max_polyhedron_coordinate)) {
            return fail(ErrorCode::limit_exceeded,
                        "its normal is too long, or its offset per length of its normal is beyond "
                        "2^300, about 2e90",
                        where);
        }
        result.planes.push_back({normal / length, offset});
        size = std::max(size, std::abs(offset));
    }
    if (size == 0) return result;
    result.exponent = std::ilogb(size);
    for (Plane& plane : result.planes) plane.offset = std::ldexp(plane.offset, -result.exponent);
    return result;
}

/// A ball in all the planes, whose radius is no more than rounding allows; its radius is measured
/// again from its centre, as the simplex method answers to a rounded question.
std::optional<Ball> ball_inside(const std::vector<Plane>& planes, Progress* progress)
{
    for (const Real reach : {Real(4), Real(4e3), Real(4e6), Real(4e9)}) {
        const std::optional<Ball> found = largest_ball(planes, reach, progress);
        if (!found || !found->center.allFinite()) continue;
        Real radius = std::numeric_limits<Real>::infinity();
        for (const Plane& plane : planes)
            radius = std::min(radius, plane.offset - plane.normal.dot(found->center));
        const Real least = Real(min_ball_radius) * std::max(Real(1), found->center.norm());
        if (radius > found->radius / 2 && radius > least) return Ball{found->center, radius};
    }
    return std::nullopt;
}

/// Where three planes meet, relative to the centre: refined once. Not finite if they do not.
Real3 meeting_point(const std::array<const Plane*, 3>& planes, const Real3& center)
{
    Real33 normals;
    Real3 distances;
    for (int row = 0; row < 3; ++row) {
        const Plane& plane = *planes[static_cast<std::size_t>(row)];
        normals.row(row) = plane.normal.transpose();
        distances[row] = plane.offset - plane.normal.dot(center);
    }
    const Eigen::FullPivLU<Real33> solver(normals);
    Real3 point = solver.solve(distances);
    const Real3 residual = distances - normals * point;
    point += solver.solve(residual);
    const Real error = (distances - normals * point).cwiseAbs().maxCoeff();
    if (!(error <= 1e-15L * (point.norm() + distances.cwiseAbs().maxCoeff())))
        point.setConstant(std::numeric_limits<Real>::infinity());
    return point;
}

/// The direction that two of three planes share, those that cross best; as long as `like` leads.
Real3 shared_direction(std::span<const Plane* const> planes, const Vec3& like)
{
    Real3 best = Real3::Zero();
    for (std::size_t i = 0; i < planes.size(); ++i) {
        for (std::size_t j = i + 1; j < planes.size(); ++j) {
            const Real3 direction = planes[i]->normal.cross(planes[j]->normal);
            if (direction.squaredNorm() > best.squaredNorm()) best = direction;
        }
    }
    if (best.isZero(0)) return best;
    best.normalize();
    return best.dot(like.cast<Real>()) < 0 ? Real3(-best) : best;
}

/// Tests whether the half-spaces contain a corner, up to a tolerance, or a ray of length 1.
class Inside {
public:
    Inside(const std::vector<Plane>& planes, const Real3& center)
        : planes_(planes), center_(center.norm())
    {
        rounded_.reserve(planes.size());
        for (const Plane& plane : planes)
            rounded_.push_back({plane.normal.cast<double>(), static_cast<double>(plane.offset)});
    }

    [[nodiscard]] Real tolerance(const Real3& point) const
    {
        return Real(half_space_tolerance) * (point.norm() + center_);
    }
    [[nodiscard]] bool holds_point(const Real3& point) const
    {
        const Real limit = tolerance(point);
        const Vec3 rounded = point.cast<double>();
        const auto near = static_cast<double>(limit);
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            const Height about = rounded_height(i, rounded);
            if (about.value + about.error <= near) continue;
            if (planes_[i].normal.dot(point) - planes_[i].offset > limit) return false;
        }
        return true;
    }
    /// Whether the point is as close to a plane as this, to a rounding or two.
    [[nodiscard]] bool is_on(std::size_t plane, const Vec3& point, double distance) const
    {
        const Height about = rounded_height(plane, point);
        if (std::abs(about.value) > distance + about.error) return false;
        const Real height = planes_[plane].normal.dot(point.cast<Real>()) - planes_[plane].offset;
        return std::abs(height) <= distance;
    }
    [[nodiscard]] bool holds_ray(const Real3& ray) const
    {
        return std::ranges::all_of(planes_, [&](const Plane& plane) {
            return plane.normal.dot(ray) <= Real(half_space_ray_tolerance);
        });
    }

private:
    /// The value in doubles, which decides most cases, and a bound of its error.
    struct Height {
        double value;
        double error;
    };
    [[nodiscard]] Height rounded_height(std::size_t plane, const Vec3& point) const
    {
        const HalfSpace& rounded = rounded_[plane];
        return {rounded.normal.dot(point) - rounded.offset,
                1e-15 * (point.lpNorm<1>() + std::abs(rounded.offset))};
    }

    const std::vector<Plane>& planes_;
    std::vector<HalfSpace> rounded_;
    Real center_;
};

/// Corners and rays of the polyhedron, in doubles, units of 2^exponent still.
struct Corners {
    std::vector<Vec3> points;
    std::vector<Vec3> rays;
    Real merged = 0; ///< corners as close as this became one
};

/// Of the facets of the dual hull. A dual sliver, of planes that hardly differ, may give a corner
/// anywhere: those outside are left out, as slivers have the corners that matter for neighbours.
Result<Corners> corners_of(const std::vector<Plane>& planes, const Ball& ball,
                           std::span<const Vec3> duals,
                           std::span<const detail::HullTriangle> triangles, Progress* progress)
{
    const Inside inside(planes, ball.center);
    const Real far = 1e11L * (1 + ball.center.norm());
    Corners result;
    Real extent = 0;
    StageSteps steps(progress, "corners of half-spaces", triangles.size(), 64);
    for (const detail::HullTriangle& triangle : triangles) {
        if (!steps.done(1)) return cancelled("intersecting half-spaces");
        std::array<const Plane*, 3> meeting{};
        std::size_t count = 0;
        for (const std::uint32_t dual : triangle.vertices)
            if (dual != 0) meeting[count++] = &planes[dual - 1];
        Real3 point = Real3::Constant(std::numeric_limits<Real>::infinity());
        if (count == 3) point = meeting_point(meeting, ball.center);
        if (point.allFinite() && point.norm() < far) {
            const Vec3 corner = (point + ball.center).cast<double>();
            if (!inside.holds_point(corner.cast<Real>())) continue;
            extent = std::max(extent, point.norm());
            result.points.push_back(corner);
            continue;
        }
        const Vec3& p = duals[triangle.vertices[0]];
        const Vec3 outward =
            unit_normal({p, duals[triangle.vertices[1]]}, {p, duals[triangle.vertices[2]]});
        const Vec3 ray = shared_direction(std::span(meeting).first(count), outward).cast<double>();
        if (!ray.isZero(0) && inside.holds_ray(ray.cast<Real>())) result.rays.push_back(ray);
    }
    result.merged = std::min(1e-12L * (extent + ball.center.norm()), 1e-3L * ball.radius);
    merge_close(result.points, static_cast<double>(result.merged));
    merge_close(result.rays, 1e-9);
    return result;
}

/// Whether every facet lies in one of the planes: then no corner is missing.
Result<bool> facets_lie_in_planes(const ConvexPolyhedron& polyhedron,
                                  const std::vector<Plane>& planes, const Ball& ball, Real merged,
                                  int exponent, Progress* progress)
{
    const Inside inside(planes, ball.center);
    std::vector<Vec3> positions(polyhedron.points().begin(), polyhedron.points().end());
    std::vector<double> distances;
    distances.reserve(positions.size());
    for (Vec3& position : positions) {
        for (double& coordinate : position) coordinate = std::ldexp(coordinate, -exponent);
        const Real tolerance = inside.tolerance(position.cast<Real>());
        distances.push_back(static_cast<double>(4 * merged + 4 * tolerance));
    }
    const auto lies_in = [&](std::uint32_t facet, std::size_t plane) {
        return std::ranges::all_of(polyhedron.facet_loop(facet), [&](std::uint32_t v) {
            if (!polyhedron.is_ray(v)) return inside.is_on(plane, positions[v], distances[v]);
            const Real3 ray = polyhedron.vertex(v).cast<Real>();
            return std::abs(planes[plane].normal.dot(ray)) <= 2e-9L;
        });
    };
    StageSteps steps(progress, "facets of half-spaces", polyhedron.facet_count(), 64);
    for (std::uint32_t facet = 0; facet < polyhedron.facet_count(); ++facet) {
        if (!steps.done(1)) return cancelled("intersecting half-spaces");
        std::size_t plane = 0;
        while (plane < planes.size() && !lies_in(facet, plane)) ++plane;
        if (plane == planes.size()) return false;
    }
    return true;
}

} // namespace

Result<ConvexPolyhedron> polyhedron_of_half_spaces(std::span<const HalfSpace> given,
                                                   const Execution& execution)
{
    Progress* const progress = execution.progress;
    const auto scaled = normalised(given);
    if (!scaled) return tl::unexpected(scaled.error());
    const std::vector<Plane>& planes = scaled->planes;
    const auto holds_line = [] {
        return fail(ErrorCode::invalid_argument,
                    "the half-spaces have a whole line in common: add planes that end it");
    };
    if (planes.empty()) return holds_line();
    const std::optional<Ball> ball = ball_inside(planes, progress);
    if (is_cancelled(progress)) return cancelled("intersecting half-spaces");
    if (!ball) {
        return fail(ErrorCode::invalid_argument,
                    "the half-spaces have no volume in common: none at all, or a set that is flat "
                    "or thinner than 1e-12 of the largest offset");
    }

    // The origin represents the plane at infinity.
    std::vector<Vec3> duals = {Vec3::Zero()};
    for (const Plane& plane : planes) {
        const Real distance = plane.offset - plane.normal.dot(ball->center);
        duals.emplace_back((plane.normal / distance).cast<double>());
    }
    const detail::HullVertices vertices = {duals, static_cast<std::uint32_t>(duals.size())};
    const detail::AffineSpan span = detail::affine_span(vertices);
    if (span.dimension < 3) return holds_line();
    const auto triangles = detail::quickhull(vertices, span, progress);
    if (!triangles) return tl::unexpected(triangles.error());
    auto corners = corners_of(planes, *ball, duals, *triangles, progress);
    if (!corners) return tl::unexpected(corners.error());
    if (corners->points.empty()) return holds_line();

    for (Vec3& point : corners->points)
        for (double& coordinate : point) coordinate = std::ldexp(coordinate, scaled->exponent);
    auto polyhedron = convex_hull(corners->points, corners->rays, execution);
    if (!polyhedron) return polyhedron;
    const auto is_whole = facets_lie_in_planes(*polyhedron, planes, *ball, corners->merged,
                                               scaled->exponent, progress);
    if (!is_whole) return tl::unexpected(is_whole.error());
    if (polyhedron->dimension() < 3 || !*is_whole) {
        return fail(ErrorCode::invalid_argument,
                    "the half-spaces' common set is too thin, or its planes too close to each "
                    "other, for corners in doubles");
    }
    return polyhedron;
}

} // namespace proxima
