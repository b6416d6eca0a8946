#include "viewer/panels/local_cone.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "proxima/geometry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace proxima {
namespace {

constexpr double flat = 1e-8; // radians, as the proximity octree's builder has it

tl::unexpected<Error> no_such_feature(const char* kind, std::uint32_t id, std::size_t count)
{
    return fail(ErrorCode::invalid_argument,
                concat("there is no ", kind, " ", id, ": the mesh has ", count));
}

LocalCone cone_of(ConeShape shape, std::vector<ConeCorner> corners, const Vec3& outward)
{
    Vec3 middle = Vec3::Zero();
    for (const ConeCorner& corner : corners) middle += corner.direction;
    const bool is_behind = middle.dot(outward) < -flat * middle.norm() * outward.norm();
    return {shape, is_behind ? ConeSide::behind : ConeSide::outside, std::move(corners)};
}

Result<LocalCone> cone_of_face(const TriangleMesh& mesh, TriangleId id)
{
    const Triangle triangle = mesh.triangle(id);
    if (is_degenerate(triangle)) {
        return fail(ErrorCode::invalid_mesh,
                    concat("triangle ", to_index(id), " has no area, so it has no normal"));
    }
    const Vec3 normal = unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
    return cone_of(ConeShape::solid,
                   {{triangle[0], normal}, {triangle[1], normal}, {triangle[2], normal}}, normal);
}

/// Directions across an edge, as angles.
struct Across {
    Vec3 x = Vec3::UnitX();
    Vec3 y = Vec3::UnitY();

    [[nodiscard]] double angle(const Vec3& d) const { return std::atan2(d.dot(y), d.dot(x)); }
    [[nodiscard]] Vec3 at(double angle) const { return std::cos(angle) * x + std::sin(angle) * y; }
};

Result<LocalCone> cone_of_edge(const TriangleMesh& mesh, const Topology& topology, EdgeId edge)
{
    constexpr double pi = std::numbers::pi;
    const auto [p, q] = topology.vertices(edge);
    const Vec3& from = mesh.position(p);
    const Vec3& to = mesh.position(q);
    const Vec3 along = (to - from).stableNormalized();
    if (along.squaredNorm() == 0.0)
        return fail(ErrorCode::invalid_mesh, concat("edge ", to_index(edge), " has no length"));
    Vec3 outward = Vec3::Zero();
    const Vec3 any = along.unitOrthogonal();
    const Across across = {any, along.cross(any)};
    std::vector<double> faces; // where they go from the edge
    for (const TriangleId id : topology.triangles(edge)) {
        const Triangle triangle = mesh.triangle(id);
        if (is_degenerate(triangle)) continue;
        const Vec3 normal = unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
        outward += normal;
        Vec3 inward = normal.cross(along);
        for (const Vec3& corner : triangle.vertices) {
            if (corner != from && corner != to && inward.dot(corner - from) < 0.0) inward = -inward;
        }
        faces.push_back(across.angle(inward));
    }
    if (faces.empty()) {
        return fail(ErrorCode::invalid_mesh,
                    concat("all triangles of edge ", to_index(edge), " are of no area"));
    }
    // The widest gap between neighbours; of a lone face all round.
    std::ranges::sort(faces);
    double begin = faces.back();
    double gap = faces.front() + 2.0 * pi - faces.back();
    for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
        if (faces[i + 1] - faces[i] > gap) {
            gap = faces[i + 1] - faces[i];
            begin = faces[i];
        }
    }
    if (gap < pi - flat) return LocalCone{}; // three or more faces, all round it
    if (gap < pi + flat) {
        Vec3 up = across.at(begin + 0.5 * pi);
        if (faces.size() == 2 && up.dot(outward) < 0.0) up = -up;
        return cone_of(ConeShape::flat, {{from, up}, {to, up}}, outward);
    }
    const double span = gap - pi;
    const int pieces = std::max(1, static_cast<int>(std::ceil(span / (0.5 * pi))));
    std::vector<ConeCorner> corners;
    for (const bool back : {false, true}) {
        for (int i = 0; i <= pieces; ++i) {
            const double part = static_cast<double>(back ? pieces - i : i) / pieces;
            corners.push_back({back ? to : from, across.at(begin + 0.5 * pi + part * span),
                               i == 0 || i == pieces});
        }
    }
    return cone_of(ConeShape::solid, std::move(corners), outward);
}

/// Compares directions, and counts how often.
class Comparer {
public:
    /// Whether no edge goes in a direction's half-space.
    [[nodiscard]] bool is_normal(const Vec3& direction, std::span<const Vec3> edges)
    {
        return std::ranges::all_of(edges, [&](const Vec3& edge) {
            ++count_;
            return edge.dot(direction) <= 0.1 * flat;
        });
    }

    [[nodiscard]] bool has_near(std::span<const Vec3> directions, const Vec3& direction)
    {
        return std::ranges::any_of(directions, [&](const Vec3& other) {
            ++count_;
            return (other - direction).norm() < flat;
        });
    }

    void add_once(std::vector<Vec3>& directions, const Vec3& direction)
    {
        if (!has_near(directions, direction)) directions.push_back(direction);
    }

    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

private:
    std::uint64_t count_ = 0;
};

/// Edges in the order in which they are asked whether a direction is normal: those that refused one
/// lately are the first, for they refuse most others.
class AskedEdges {
public:
    AskedEdges(std::span<const Vec3> edges, Comparer& comparer)
        : edges_(edges.begin(), edges.end()), comparer_(comparer)
    {}

    /// Whether one of the first `count` refuses the direction.
    [[nodiscard]] bool refuse(const Vec3& direction, std::size_t count)
    {
        for (std::size_t i = 0; i < std::min(count, edges_.size()); ++i) {
            if (comparer_.is_normal(direction, {&edges_[i], 1})) continue;
            const auto first = edges_.begin();
            const auto at = first + static_cast<std::ptrdiff_t>(i);
            std::rotate(first, at, at + 1);
            return true;
        }
        return false;
    }

private:
    std::vector<Vec3> edges_;
    Comparer& comparer_;
};

/// The cone's outermost directions: each is across two edges. Where two opposite ones are found all
/// edges lie in the plane across them, and no more are sought.
std::vector<Vec3> extreme_directions(std::span<const Vec3> edges, Comparer& comparer)
{
    constexpr std::size_t few = 16;
    AskedEdges asked(edges, comparer);
    std::vector<Vec3> found;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        for (std::size_t k = i + 1; k < edges.size(); ++k) {
            const Vec3 across = edges[i].cross(edges[k]);
            if (across.norm() < flat) continue;
            int added = 0;
            for (const Vec3& direction : {Vec3(across.normalized()), Vec3(-across.normalized())}) {
                if (asked.refuse(direction, few) || comparer.has_near(found, direction) ||
                    asked.refuse(direction, edges.size()))
                    continue;
                found.push_back(direction);
                ++added;
            }
            if (added == 2) return found;
        }
    }
    return found;
}

/// In a circle round their middle.
void sort_round(std::vector<Vec3>& directions)
{
    Vec3 middle = Vec3::Zero();
    for (const Vec3& direction : directions) middle += direction;
    const Vec3 x = middle.unitOrthogonal();
    const Vec3 y = middle.cross(x).normalized();
    std::ranges::sort(directions, {},
                      [&](const Vec3& d) { return std::atan2(d.dot(y), d.dot(x)); });
}

/// All edges lie in the plane across `up`, which is a direction of the cone as -up is.
LocalCone cone_of_flat_fan(const Vec3& at, Vec3 up, std::span<const Vec3> edges,
                           const Vec3& outward, Comparer& comparer)
{
    if (up.dot(outward) < 0.0) up = -up;
    std::vector<Vec3> sideways;
    for (const Vec3& edge : edges) {
        const Vec3 across = up.cross(edge).normalized();
        for (const Vec3& direction : {across, Vec3(-across)})
            if (comparer.is_normal(direction, edges)) comparer.add_once(sideways, direction);
    }
    if (sideways.empty()) return cone_of(ConeShape::line, {{at, up}}, outward);
    if (sideways.size() == 1)
        return cone_of(ConeShape::flat, {{at, up}, {at, sideways[0], false}, {at, -up}}, outward);
    return cone_of(ConeShape::solid, {{at, up}, {at, sideways[0]}, {at, -up}, {at, sideways[1]}},
                   outward);
}

Result<LocalCone> cone_of_vertex(const TriangleMesh& mesh, const Topology& topology,
                                 VertexId vertex, Comparer& comparer)
{
    if (topology.triangles(vertex).empty()) {
        return fail(
            ErrorCode::invalid_argument,
            concat("no triangle uses vertex ", to_index(vertex), ": it is not on the surface"));
    }
    const Vec3& at = mesh.position(vertex);
    Vec3 outward = Vec3::Zero(); // by the angles that faces have there
    for (const TriangleId id : topology.triangles(vertex)) {
        const Triangle triangle = mesh.triangle(id);
        if (is_degenerate(triangle)) continue;
        std::vector<Vec3> others;
        for (const Vec3& corner : triangle.vertices)
            if (corner != at) others.push_back((corner - at).stableNormalized());
        if (others.size() != 2) continue;
        outward += std::acos(std::clamp(others[0].dot(others[1]), -1.0, 1.0)) *
                   unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
    }
    std::vector<Vec3> edges;
    for (const EdgeId edge : topology.edges(vertex)) {
        const Vec3 along = mesh.position(topology.other_end(edge, vertex)) - at;
        if (along.squaredNorm() > 0.0) edges.push_back(along.stableNormalized());
    }
    std::vector<Vec3> directions = extreme_directions(edges, comparer);
    for (const Vec3& direction : directions) {
        if (comparer.is_normal(-direction, edges))
            return cone_of_flat_fan(at, direction, edges, outward, comparer);
    }
    if (directions.empty()) return LocalCone{};
    if (directions.size() > 2) sort_round(directions);
    std::vector<ConeCorner> corners;
    corners.reserve(directions.size());
    for (const Vec3& direction : directions) corners.push_back({at, direction});
    const ConeShape shape = corners.size() == 1   ? ConeShape::line
                            : corners.size() == 2 ? ConeShape::flat
                                                  : ConeShape::solid;
    return cone_of(shape, std::move(corners), outward);
}

} // namespace

Result<LocalCone> local_cone(const TriangleMesh& mesh, const Topology& topology, Feature feature)
{
    switch (feature.kind) {
    case FeatureKind::vertex: {
        if (feature.id >= mesh.vertex_count())
            return no_such_feature("vertex", feature.id, mesh.vertex_count());
        Comparer comparer;
        auto cone = cone_of_vertex(mesh, topology, VertexId{feature.id}, comparer);
        if (cone) cone->comparisons = comparer.count();
        return cone;
    }
    case FeatureKind::edge:
        if (feature.id >= topology.edge_count())
            return no_such_feature("edge", feature.id, topology.edge_count());
        return cone_of_edge(mesh, topology, EdgeId{feature.id});
    case FeatureKind::face:
        break;
    }
    if (feature.id >= mesh.triangle_count())
        return no_such_feature("face", feature.id, mesh.triangle_count());
    return cone_of_face(mesh, TriangleId{feature.id});
}

} // namespace proxima
