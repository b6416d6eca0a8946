#include "query/closest/feature_distance.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "index/binary_tree.h"
#include "index/row_tables.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// A vector with the operations of row_distance-inl.h, in their order.
struct Terms {
    double x;
    double y;
    double z;
};

Terms scaled_difference(const Vec3& a, const Vec3& b, double up) noexcept
{
    return {up * (a.x() - b.x()), up * (a.y() - b.y()), up * (a.z() - b.z())};
}
double dot(const Terms& a, const Terms& b) noexcept
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Terms cross(const Terms& a, const Terms& b) noexcept
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A triangle and the ids of its features.
struct NamedTriangle {
    Triangle shape;
    std::uint32_t id;
    std::array<std::uint32_t, 3> vertices;
    std::array<std::uint32_t, 3> edges;
};

template <class Scalar>
NamedTriangle named(const TriangleRow<Scalar>& row) noexcept
{
    return {row.corners(),
            row.triangle_id(),
            {row.vertices[0], row.vertices[1], row.vertices[2]},
            {row.edges[0], row.edges[1], row.edges[2]}};
}

void offer_features(const NamedTriangle& triangle, const Vec3& p, const RowScale& scale,
                    NearestFeature& best) noexcept
{
    const Triangle& shape = triangle.shape;
    const auto offer = [&](double squared, FeatureKind kind, std::uint32_t id) {
        if (!(squared <= best.squared)) return;
        const NearestFeature found = {squared, {kind, id}};
        if (found < best) best = found;
    };
    offer(foot_inside(shape, p, scale).squared, FeatureKind::face, triangle.id);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = k == 2 ? 0 : k + 1;
        offer(squared_distance(shape.vertices[k], p, scale), FeatureKind::vertex,
              triangle.vertices[k]);
        if (triangle.edges[k] == to_index(no_edge)) continue;
        const bool ascends = triangle.vertices[k] < triangle.vertices[next];
        offer(foot_between(shape.vertices[ascends ? k : next], shape.vertices[ascends ? next : k],
                           p, scale)
                  .squared,
              FeatureKind::edge, triangle.edges[k]);
    }
}

/// The mesh's scale, or for a triangle that is too small in it its own.
double unit_of_thin(const Triangle& triangle, const RowScale& scale) noexcept
{
    const double size = std::max((triangle[1] - triangle[0]).cwiseAbs().maxCoeff(),
                                 (triangle[2] - triangle[0]).cwiseAbs().maxCoeff());
    if (!(size > 0 && size * scale.up < least_side)) return scale.up;
    return std::ldexp(1.0, std::clamp(-std::ilogb(size), -1000, 1000));
}

std::size_t corner_of(const TriangleCorners& corners, VertexId vertex) noexcept
{
    const auto found = std::ranges::find(corners, to_index(vertex));
    return static_cast<std::size_t>(found - corners.begin());
}

} // namespace

RowScale row_scale_of(const TriangleMesh& mesh) noexcept
{
    const double scale = index_frame(bounding_box(mesh), has_floats(mesh)).scale;
    return {scale, 1 / scale};
}

double squared_distance(const Vec3& vertex, const Vec3& p, const RowScale& scale) noexcept
{
    const Terms q = scaled_difference(p, vertex, scale.up);
    return dot(q, q);
}

SegmentFoot foot_between(const Vec3& from, const Vec3& to, const Vec3& p,
                         const RowScale& scale) noexcept
{
    const Terms d = scaled_difference(p, from, scale.up);
    const Terms side = scaled_difference(to, from, scale.up);
    const double length = dot(side, side);
    const double ahead = dot(d, side);
    if (!(ahead > 0 && ahead < length)) return {};
    const double along = ahead / length;
    const Terms rest = {d.x - along * side.x, d.y - along * side.y, d.z - along * side.z};
    return {dot(rest, rest), along};
}

FaceFoot foot_inside(const Triangle& face, const Vec3& p, const RowScale& scale) noexcept
{
    FaceFoot foot;
    std::array<double, 3> parts{}; // of the corner across side i
    if (is_thin(face, scale.up)) {
        const ThinInside inside = inside_of_thin(face, p, scale);
        if (!(inside.squared < std::numeric_limits<double>::infinity())) return {};
        foot.squared = inside.squared;
        parts = {inside.weights[2], inside.weights[0], inside.weights[1]};
    } else {
        foot.squared = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 3; ++i) {
            const Vec3& corner = face[i];
            const Vec3& next = face[(i + 1) % 3];
            const Vec3& last = face[(i + 2) % 3];
            const Terms q = scaled_difference(p, corner, scale.up);
            const Terms e = scaled_difference(next, corner, scale.up);
            const Terms normal = cross(e, scaled_difference(last, next, scale.up));
            const double height = dot(normal, q);
            foot.squared = std::min(foot.squared, height * height / dot(normal, normal));
            parts[static_cast<std::size_t>(i)] = dot(normal, cross(e, q));
        }
        if (!(parts[0] > 0 && parts[1] > 0 && parts[2] > 0)) return {};
    }
    const double all = parts[0] + parts[1] + parts[2];
    const double v = parts[2] / all;
    const double w = parts[0] / all;
    foot.weights = {std::max(0.0, 1 - v - w), v, w};
    return foot;
}

ThinInside inside_of_thin(const Triangle& triangle, const Vec3& p, const RowScale& scale) noexcept
{
    const double up = unit_of_thin(triangle, scale);
    // From a corner, as differences of coordinates: the closest point itself would be rounded to these.
    const auto from_corner = [&](const Vec3& q) -> Vec3 { return (q - triangle[0]) * up; };
    const Triangle scaled = {{Vec3::Zero(), from_corner(triangle[1]), from_corner(triangle[2])}};
    const Vec3 point = from_corner(p);
    // From so far its corners are as near as its inside.
    if (!(point.cwiseAbs().maxCoeff() < endless_distance)) return {};
    const TrianglePoint inside = closest_point(scaled, point);
    // Differences may be rounded off one line.
    if (inside.part != TrianglePart::inside || is_degenerate(triangle)) return {};
    const Vec3 apart = (point - inside.point) * (scale.up / up);
    return {apart.squaredNorm(), inside.weights};
}

void offer_triangle(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                    const Vec3& p, const RowScale& scale, NearestFeature& best) noexcept
{
    const std::array<EdgeId, 3>& edges = topology.edges(triangle);
    offer_features({mesh.triangle(triangle),
                    to_index(triangle),
                    mesh.triangles()[to_index(triangle)],
                    {to_index(edges[0]), to_index(edges[1]), to_index(edges[2])}},
                   p, scale, best);
}

void offer_row(const TriangleRow<float>& row, const Vec3& p, const RowScale& scale,
               NearestFeature& best) noexcept
{
    offer_features(named(row), p, scale, best);
}

void offer_row(const TriangleRow<double>& row, const Vec3& p, const RowScale& scale,
               NearestFeature& best) noexcept
{
    offer_features(named(row), p, scale, best);
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
                                const NearestFeature& nearest, const Vec3& p,
                                const RowScale& scale) noexcept
{
    const Feature& feature = nearest.feature;
    ClosestFeature closest;
    closest.feature = feature;
    closest.triangle = lowest_triangle(topology, feature);
    closest.squared_distance = scale.unscale_squared(nearest.squared);
    const TriangleCorners& corners = mesh.triangles()[to_index(closest.triangle)];
    if (feature.kind == FeatureKind::vertex) {
        closest.point = mesh.position(VertexId{feature.id});
        closest.barycentric[corner_of(corners, VertexId{feature.id})] = 1;
    } else if (feature.kind == FeatureKind::edge) {
        const EdgeVertices& ends = topology.vertices(EdgeId{feature.id});
        const Vec3& from = mesh.position(ends[0]);
        const Vec3& to = mesh.position(ends[1]);
        const double along = foot_between(from, to, p, scale).along;
        closest.point = (1 - along) * from + along * to;
        closest.barycentric[corner_of(corners, ends[0])] = 1 - along;
        closest.barycentric[corner_of(corners, ends[1])] = along;
    } else {
        const Triangle face = mesh.triangle(closest.triangle);
        closest.barycentric = foot_inside(face, p, scale).weights;
        closest.point = closest.barycentric[0] * face[0] + closest.barycentric[1] * face[1] +
                        closest.barycentric[2] * face[2];
    }
    return closest;
}

} // namespace proxima
