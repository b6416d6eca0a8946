#include "query/closest/feature_distance.h"

#include "geometry/closest_point.h"

#include <algorithm>
#include <optional>

namespace proxima {

namespace {

/// The points of features as computed are within this part of the coordinates of where they are.
constexpr double point_error = 0x1p-48;

/// The closest point of a segment where it is strictly between the ends.
std::optional<SegmentPoint> closest_point_between(const Vec3& from, const Vec3& to,
                                                  const Vec3& p) noexcept
{
    const double ux = to.x() - from.x();
    const double uy = to.y() - from.y();
    const double uz = to.z() - from.z();
    const double along =
        (p.x() - from.x()) * ux + (p.y() - from.y()) * uy + (p.z() - from.z()) * uz;
    const double length = ux * ux + uy * uy + uz * uz;
    if (!(along > 0 && along < length)) return std::nullopt;
    const double t = along / length;
    if (!(t > 0 && t < 1)) return std::nullopt;
    return SegmentPoint{Segment{from, to}.at(t), t};
}

std::optional<SegmentPoint> closest_point_between(const TriangleMesh& mesh,
                                                  const EdgeVertices& ends, const Vec3& p) noexcept
{
    return closest_point_between(mesh.position(ends[0]), mesh.position(ends[1]), p);
}

/// Whether all points of the triangle, as computed, are farther than `squared`: by its box.
bool is_farther(const Triangle& triangle, const Vec3& p, double squared) noexcept
{
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = triangle[0][axis];
        const double b = triangle[1][axis];
        const double c = triangle[2][axis];
        const double low = std::min(std::min(a, b), c);
        const double high = std::max(std::max(a, b), c);
        const double error = point_error * std::max(-low, high);
        const double gap = std::max(std::max(low - p[axis], p[axis] - high) - error, 0.0);
        sum += gap * gap;
    }
    return sum > squared;
}

/// The foot of p in a face: on its sides within rounding is on its sides.
std::optional<TrianglePoint> closest_point_of_face(const Triangle& face, const Vec3& p) noexcept
{
    constexpr double rounding = 0x1p-50;
    auto foot = closest_point_inside(face, p);
    if (foot && *std::ranges::min_element(foot->weights) < rounding) return std::nullopt;
    return foot;
}

std::size_t corner_of(const TriangleCorners& corners, VertexId vertex) noexcept
{
    const auto place = std::ranges::find(corners, index(vertex));
    return static_cast<std::size_t>(place - corners.begin());
}

} // namespace

double squared_distance(const TriangleMesh& mesh, VertexId vertex, const Vec3& p) noexcept
{
    return squared_distance(p, mesh.position(vertex));
}

double squared_distance(const TriangleMesh& mesh, const Topology& topology, EdgeId edge,
                        const Vec3& p) noexcept
{
    const auto foot = closest_point_between(mesh, topology.vertices(edge), p);
    return foot ? squared_distance(p, foot->point) : no_distance;
}

double squared_distance(const TriangleMesh& mesh, TriangleId face, const Vec3& p) noexcept
{
    const auto foot = closest_point_of_face(mesh.triangle(face), p);
    return foot ? squared_distance(p, foot->point) : no_distance;
}

void offer_triangle(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                    const Vec3& p, NearestFeature& best) noexcept
{
    const Triangle shape = mesh.triangle(triangle);
    if (is_farther(shape, p, best.squared)) return;
    const auto offer = [&](double squared, FeatureKind kind, std::uint32_t id) {
        if (!(squared <= best.squared)) return;
        const NearestFeature found = {squared, {kind, id}};
        if (found < best) best = found;
    };
    if (const auto foot = closest_point_of_face(shape, p)) {
        offer(squared_distance(p, foot->point), FeatureKind::face, index(triangle));
    }
    const TriangleCorners& corners = mesh.triangles()[index(triangle)];
    const std::array<EdgeId, 3>& edges = topology.edges(triangle);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = k == 2 ? 0 : k + 1;
        offer(squared_distance(p, shape.vertices[k]), FeatureKind::vertex, corners[k]);
        if (edges[k] == no_edge) continue;
        const bool ascends = corners[k] < corners[next];
        const auto foot = closest_point_between(shape.vertices[ascends ? k : next],
                                                shape.vertices[ascends ? next : k], p);
        if (foot) {
            offer(squared_distance(p, foot->point), FeatureKind::edge, index(edges[k]));
        }
    }
}

TriangleId lowest_triangle(const Topology& topology, const Feature& feature) noexcept
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        return topology.triangles(VertexId{feature.id}).front();
    case FeatureKind::edge:
        return topology.triangles(EdgeId{feature.id}).front();
    case FeatureKind::face:
        break;
    }
    return TriangleId{feature.id};
}

ClosestFeature describe_closest(const TriangleMesh& mesh, const Topology& topology,
                                const Feature& feature, const Vec3& p) noexcept
{
    ClosestFeature closest;
    closest.feature = feature;
    closest.triangle = lowest_triangle(topology, feature);
    const TriangleCorners& corners = mesh.triangles()[index(closest.triangle)];
    if (feature.kind == FeatureKind::vertex) {
        closest.point = mesh.position(VertexId{feature.id});
        closest.barycentric[corner_of(corners, VertexId{feature.id})] = 1;
    } else if (feature.kind == FeatureKind::edge) {
        const EdgeVertices& ends = topology.vertices(EdgeId{feature.id});
        const auto foot = closest_point_between(mesh, ends, p);
        closest.point = foot->point;
        closest.barycentric[corner_of(corners, ends[0])] = 1 - foot->t;
        closest.barycentric[corner_of(corners, ends[1])] = foot->t;
    } else {
        const auto foot = closest_point_of_face(mesh.triangle(closest.triangle), p);
        closest.point = foot->point;
        closest.barycentric = foot->weights;
    }
    closest.squared_distance = squared_distance(p, closest.point);
    return closest;
}

} // namespace proxima
