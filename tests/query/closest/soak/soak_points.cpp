#include "query/closest/soak/soak_points.h"

#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"

#include "proxima/closest_feature.h"

#include <algorithm>
#include <cmath>

namespace proxima::soak {
namespace {

double part(std::mt19937_64& random)
{
    return std::uniform_real_distribution<double>(0, 1)(random);
}

Vec3 direction(std::mt19937_64& random)
{
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    return Vec3(x, y, normal(random)).normalized();
}

} // namespace

std::string_view name_of(PointSet set) noexcept
{
    switch (set) {
    case PointSet::volume:
        return "volume";
    case PointSet::near_surface:
        return "near surface";
    case PointSet::boundaries:
        return "boundaries";
    case PointSet::outside:
        break;
    }
    return "outside";
}

PointMaker::PointMaker(const TriangleMesh& mesh, const Topology& topology, const MeshIndex& listed)
    : mesh_(mesh), topology_(topology), index_(listed), box_(bounding_box(mesh)),
      diagonal_(box_.extent().norm())
{
    double area = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        area += scaled_normal(mesh.triangle(TriangleId{i})).norm();
        areas_.push_back(area);
    }
}

std::vector<Vec3> PointMaker::make(PointSet set, std::size_t count, std::uint64_t seed) const
{
    Random random(seed);
    std::vector<Vec3> points;
    points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        switch (set) {
        case PointSet::volume:
            points.push_back(in_volume(random));
            break;
        case PointSet::near_surface:
            points.push_back(near_surface(random));
            break;
        case PointSet::boundaries:
            points.push_back(on_boundary(i % 16, random));
            break;
        case PointSet::outside:
            points.push_back(outside(random));
            break;
        }
    }
    return points;
}

TriangleId PointMaker::any_triangle(Random& random) const
{
    return TriangleId{static_cast<std::uint32_t>(random() % mesh_.triangle_count())};
}

Vec3 PointMaker::in_volume(Random& random) const
{
    Vec3 point;
    for (int axis = 0; axis < 3; ++axis)
        point[axis] = box_.center()[axis] + 1.2 * (part(random) - 0.5) * box_.extent()[axis];
    return point;
}

/// Half of them uniform by area, half by triangle.
Vec3 PointMaker::on_surface(Random& random) const
{
    std::uint32_t id = to_index(any_triangle(random));
    if (random() % 2 == 0) {
        const auto chosen = std::ranges::upper_bound(areas_, areas_.back() * part(random));
        id = static_cast<std::uint32_t>(
            std::min<std::ptrdiff_t>(chosen - areas_.begin(), std::ssize(areas_) - 1));
    }
    const Triangle triangle = mesh_.triangle(TriangleId{id});
    const double across = std::sqrt(part(random));
    const double along = part(random);
    return (1 - across) * triangle[0] + across * (1 - along) * triangle[1] +
           across * along * triangle[2];
}

Vec3 PointMaker::near_surface(Random& random) const
{
    return on_surface(random) + 0.01 * diagonal_ * (2 * part(random) - 1) * direction(random);
}

Vec3 PointMaker::outside(Random& random) const
{
    const double half = index_.parts().lists()->frame().half;
    while (true) {
        Vec3 point;
        const double reach = random() % 2 == 0 ? 3.0 : std::pow(10.0, 6 * part(random));
        for (int axis = 0; axis < 3; ++axis) {
            point[axis] = index_.parts().lists()->frame().center[axis] +
                          reach * half * (2 * part(random) - 1);
        }
        if (!index_.parts().lists()->frame().contains(point)) return point;
    }
}

Vec3 PointMaker::on_boundary(std::size_t kind, Random& random) const
{
    switch (kind) {
    case 0:
    case 1:
    case 2:
        return on_cell(in_volume(random), random);
    case 3:
    case 4:
    case 5:
        return on_cell(near_surface(random), random);
    case 6:
    case 7:
    case 8:
        return above_vertex(random);
    case 9:
    case 10:
    case 11:
        return above_edge(random);
    case 12:
    case 13:
        return above_circumcentre(random);
    case 14:
        return 0.5 * on_surface(random) + 0.5 * on_surface(random);
    default:
        return between_features(random);
    }
}

/// Moved to the side of a cell along one axis, two, or all three; some by the least step.
Vec3 PointMaker::on_cell(Vec3 point, Random& random) const
{
    const RootFrame& frame = index_.parts().lists()->frame();
    const auto axes = 1 + random() % 7;
    for (int axis = 0; axis < 3; ++axis) {
        if ((axes >> static_cast<unsigned>(axis) & 1U) == 0) continue;
        const double cell = std::ldexp(frame.half, -static_cast<int>(random() % 14));
        const double place = std::round((point[axis] - frame.center[axis]) / cell);
        point[axis] = frame.center[axis] + place * cell;
        const auto step = random() % 4;
        if (step == 0) point[axis] = std::nextafter(point[axis], -HUGE_VAL);
        if (step == 1) point[axis] = std::nextafter(point[axis], HUGE_VAL);
    }
    return point;
}

/// Along a triangle's normal, either way; zero where it has none.
Vec3 PointMaker::height_over(TriangleId triangle, Random& random) const
{
    const Vec3 normal = scaled_normal(mesh_.triangle(triangle));
    const double length = normal.norm();
    if (!(length > 0)) return Vec3::Zero();
    const double height = diagonal_ * std::ldexp(0.5, -static_cast<int>(random() % 16));
    return (random() % 2 == 0 ? height : -height) / length * normal;
}

/// Between a vertex and a triangle of it, or in the plane between a vertex and an edge of it.
Vec3 PointMaker::above_vertex(Random& random) const
{
    const TriangleId triangle = any_triangle(random);
    const std::uint32_t corner = mesh_.triangles()[to_index(triangle)][random() % 3];
    Vec3 point = mesh_.position(VertexId{corner}) + height_over(triangle, random);
    if (random() % 2 == 0) return point;
    const auto edges = topology_.edges(VertexId{corner});
    if (edges.empty()) return point;
    const EdgeId edge = edges[random() % edges.size()];
    const Vec3 at = mesh_.position(VertexId{corner});
    const Vec3 along = mesh_.position(topology_.other_end(edge, VertexId{corner})) - at;
    if (!(along.norm() > 0)) return point;
    const Vec3 away =
        diagonal_ * std::ldexp(0.5, -static_cast<int>(random() % 16)) * direction(random);
    return at + away - away.dot(along) / along.squaredNorm() * along;
}

/// Between an edge and a triangle of it: over one of its points, its ends and middle among them.
Vec3 PointMaker::above_edge(Random& random) const
{
    const TriangleId triangle = any_triangle(random);
    const Triangle shape = mesh_.triangle(triangle);
    const auto corner = static_cast<int>(random() % 3);
    const std::array parts = {0.0, 0.5, 1.0, part(random), part(random)};
    const double t = parts[random() % parts.size()];
    return shape[corner] + t * (shape[(corner + 1) % 3] - shape[corner]) +
           height_over(triangle, random);
}

/// As far from all three corners, in the triangle's plane or over it.
Vec3 PointMaker::above_circumcentre(Random& random) const
{
    const TriangleId triangle = any_triangle(random);
    const Triangle shape = mesh_.triangle(triangle);
    const Vec3 b = shape[1] - shape[0];
    const Vec3 c = shape[2] - shape[0];
    const Vec3 normal = b.cross(c);
    const double area = normal.squaredNorm();
    if (!(area > 0)) return shape[0];
    const Vec3 centre = (b.squaredNorm() * c - c.squaredNorm() * b).cross(normal) / (2 * area);
    if (!(centre.norm() < 2 * diagonal_)) return shape[0];
    const Vec3 point = shape[0] + centre;
    return random() % 2 == 0 ? point : Vec3(point + height_over(triangle, random));
}

/// On a segment, the last double before the closest feature changes, or the first one after.
Vec3 PointMaker::between_features(Random& random) const
{
    Vec3 from = random() % 2 == 0 ? in_volume(random) : near_surface(random);
    Vec3 to = random() % 2 == 0 ? in_volume(random) : near_surface(random);
    const Feature feature = closest_feature(index_, from)->feature;
    if (closest_feature(index_, to)->feature == feature) return 0.5 * from + 0.5 * to;
    for (int i = 0; i < 60; ++i) {
        const Vec3 middle = 0.5 * from + 0.5 * to;
        if (middle == from || middle == to) break;
        (closest_feature(index_, middle)->feature == feature ? from : to) = middle;
    }
    return random() % 2 == 0 ? from : to;
}

} // namespace proxima::soak
