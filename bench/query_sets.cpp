#include "query_sets.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_set>

namespace proxima::bench {
namespace {

using Random = std::mt19937_64;

constexpr double step_length = 1e-4; ///< of the diagonal
constexpr double turn = 0.03;        ///< standard deviation of a step's turn about either axis
constexpr double shell_cell = 0.01;  ///< edge, of the diagonal
constexpr std::size_t longest_run = 1000;

Vec3 normal_vector(Random& random)
{
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    return {x, y, normal(random)};
}

Vec3 direction(Random& random)
{
    return normal_vector(random).normalized();
}

/// Points on a mesh, uniform by area.
class SurfacePoints {
public:
    explicit SurfacePoints(const TriangleMesh& mesh) : mesh_(mesh)
    {
        double area = 0;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            area += scaled_normal(mesh.triangle(TriangleId{i})).norm();
            areas_.push_back(area);
        }
    }

    Vec3 operator()(Random& random) const
    {
        std::uniform_real_distribution<double> unit;
        const auto chosen = std::ranges::upper_bound(areas_, areas_.back() * unit(random));
        const auto last = static_cast<std::ptrdiff_t>(areas_.size()) - 1;
        const auto id = std::min(chosen - areas_.begin(), last);
        const Triangle triangle = mesh_.triangle(TriangleId{static_cast<std::uint32_t>(id)});
        const double across = std::sqrt(unit(random));
        const double along = unit(random);
        return (1 - across) * triangle[0] + across * (1 - along) * triangle[1] +
               across * along * triangle[2];
    }

private:
    const TriangleMesh& mesh_;
    std::vector<double> areas_; ///< running sums
};

/// A walk that stays in the cells of a grid that the surface goes through: in those that hold one
/// of many points of the surface.
class ShellWalk {
public:
    ShellWalk(const SurfacePoints& surface, double diagonal, Random& random)
        : cell_(shell_cell * diagonal), step_(step_length * diagonal)
    {
        constexpr int samples = 300000;
        for (int i = 0; i < samples; ++i) {
            place_ = surface(random);
            shell_.insert(code(cell_of(place_)));
        }
        heading_ = direction(random);
    }

    Vec3 next(Random& random)
    {
        heading_ = (heading_ + turn * normal_vector(random)).normalized();
        const Cell from = cell_of(place_);
        const Cell to = cell_of(place_ + step_ * heading_);
        if (!shell_.contains(code(to))) {
            // Turned back along the axes on which it left, it stays in the cell where it is.
            for (std::size_t k = 0; k < 3; ++k)
                if (to[k] != from[k]) heading_[static_cast<int>(k)] *= -1;
        }
        place_ += step_ * heading_;
        return place_;
    }

private:
    using Cell = std::array<std::int64_t, 3>;

    Cell cell_of(const Vec3& point) const
    {
        const Vec3 scaled = (point / cell_).array().floor();
        return {std::llround(scaled.x()), std::llround(scaled.y()), std::llround(scaled.z())};
    }

    /// Of cells of one mesh, which is at most 101 wide, no two have the same.
    static std::int64_t code(const Cell& cell)
    {
        return cell[0] + 1024 * (cell[1] + 1024 * cell[2]);
    }

    double cell_;
    double step_;
    std::unordered_set<std::int64_t> shell_;
    Vec3 place_ = Vec3::Zero();
    Vec3 heading_ = Vec3::UnitX();
};

} // namespace

std::array<QuerySet, 3> query_sets(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed)
{
    const Box box = bounding_box(mesh);
    const double diagonal = box.extent().norm();
    const SurfacePoints surface(mesh);
    std::array<QuerySet, 3> sets = {{{"a", {}}, {"b", {}}, {"c", {}}}};
    for (QuerySet& set : sets) set.points.reserve(count);

    Random random(seed);
    std::uniform_real_distribution<double> signed_unit(-1, 1);
    for (std::size_t i = 0; i < count; ++i) {
        const double x = signed_unit(random);
        const double y = signed_unit(random);
        const Vec3 place(x, y, signed_unit(random));
        sets[0].points.emplace_back(box.center() + 0.6 * place.cwiseProduct(box.extent()));
    }
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 foot = surface(random);
        const Vec3 away = direction(random);
        sets[1].points.emplace_back(foot + 0.01 * diagonal * signed_unit(random) * away);
    }
    ShellWalk walk(surface, diagonal, random);
    for (std::size_t i = 0; i < count; ++i) sets[2].points.push_back(walk.next(random));
    return sets;
}

QuerySample sample_of(std::span<const Vec3> points, std::size_t count)
{
    QuerySample sample;
    // Ten runs at least, so that a walk is seen in many places.
    const std::size_t run = std::clamp<std::size_t>(count / 10, 1, longest_run);
    const std::size_t runs = (count + run - 1) / run;
    for (std::size_t r = 0; r < runs; ++r) {
        const std::size_t start = r * (points.size() - run) / std::max<std::size_t>(runs - 1, 1);
        for (std::size_t i = start; i < start + run; ++i) {
            sample.points.push_back(points[i]);
            sample.places.push_back(static_cast<std::uint32_t>(i));
        }
    }
    return sample;
}

} // namespace proxima::bench
