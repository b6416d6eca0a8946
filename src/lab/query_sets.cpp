#include "lab/query_sets.h"

#include "geometry/length.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_set>

namespace proxima {
namespace {

using Random = std::mt19937_64;

constexpr double step_length = 1e-4; ///< of the diagonal
constexpr double turn = 0.03;        ///< standard deviation of a step's turn about either axis
constexpr double shell_cell = 0.01;  ///< edge, of the diagonal

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
            position_ = surface(random);
            shell_.insert(code(cell_of(position_)));
        }
        heading_ = direction(random);
    }

    Vec3 next(Random& random)
    {
        heading_ = (heading_ + turn * normal_vector(random)).normalized();
        const Cell from = cell_of(position_);
        const Cell to = cell_of(position_ + step_ * heading_);
        if (!shell_.contains(code(to))) {
            // Reflected on the axes along which it left, it stays in its cell.
            for (std::size_t k = 0; k < 3; ++k)
                if (to[k] != from[k]) heading_[static_cast<int>(k)] *= -1;
        }
        position_ += step_ * heading_;
        return position_;
    }

private:
    using Cell = std::array<std::int64_t, 3>;

    Cell cell_of(const Vec3& point) const
    {
        if (!(cell_ > 0)) return {}; // a mesh without extent
        const Vec3 scaled = (point / cell_).array().floor();
        return {std::llround(scaled.x()), std::llround(scaled.y()), std::llround(scaled.z())};
    }

    /// A number that no other cell of the mesh has, which is at most 101 cells wide; numbers of cells
    /// far from the origin wrap around.
    static std::uint64_t code(const Cell& cell)
    {
        const auto part = [&](std::size_t axis) { return static_cast<std::uint64_t>(cell[axis]); };
        return part(0) + 1024 * (part(1) + 1024 * part(2));
    }

    double cell_;
    double step_;
    std::unordered_set<std::uint64_t> shell_;
    Vec3 position_ = Vec3::Zero();
    Vec3 heading_ = Vec3::UnitX();
};

} // namespace

std::array<QuerySet, 3> query_sets(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed)
{
    const Box box = bounding_box(mesh);
    const double diagonal = length_of(box.extent());
    const SurfacePoints surface(mesh);
    std::array<QuerySet, 3> sets = {{{"a", {}}, {"b", {}}, {"c", {}}}};
    for (QuerySet& set : sets) set.points.reserve(count);

    Random random(seed);
    std::uniform_real_distribution<double> signed_unit(-1, 1);
    for (std::size_t i = 0; i < count; ++i) {
        const double x = signed_unit(random);
        const double y = signed_unit(random);
        const Vec3 position(x, y, signed_unit(random));
        sets[0].points.emplace_back(box.center() + 0.6 * position.cwiseProduct(box.extent()));
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

} // namespace proxima
