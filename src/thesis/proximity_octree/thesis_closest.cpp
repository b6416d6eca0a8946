#include "thesis/proximity_octree/thesis_closest.h"

#include "base/check.h"
#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"

#include <algorithm>

namespace proxima {
namespace {

/// A point of a feature, by its weights in one of the triangles there.
struct Candidate {
    Feature feature;
    TriangleId triangle{};
    std::array<double, 3> weights = {};
    Vec3 point = Vec3::Zero();
    double squared_distance = 0;
};

class Search {
public:
    Search(const TriangleMesh& mesh, const Topology& topology, const Vec3& query) noexcept
        : mesh_(mesh), topology_(topology), query_(query)
    {}

    void try_vertex(VertexId vertex) noexcept
    {
        Candidate candidate;
        candidate.feature = {FeatureKind::vertex, to_index(vertex)};
        candidate.triangle = topology_.triangles(vertex).front();
        candidate.weights[corner_of(candidate.triangle, vertex)] = 1;
        candidate.point = mesh_.position(vertex);
        offer(candidate);
    }

    void try_edge(EdgeId edge) noexcept
    {
        const auto [p, q] = topology_.vertices(edge);
        const SegmentPoint nearest =
            closest_point(Segment{mesh_.position(p), mesh_.position(q)}, query_);
        if (nearest.t <= 0) return try_vertex(p);
        if (nearest.t >= 1) return try_vertex(q);
        Candidate candidate;
        candidate.feature = {FeatureKind::edge, to_index(edge)};
        candidate.triangle = topology_.triangles(edge).front();
        candidate.weights[corner_of(candidate.triangle, p)] = 1 - nearest.t;
        candidate.weights[corner_of(candidate.triangle, q)] = nearest.t;
        candidate.point = nearest.point;
        offer(candidate);
    }

    void try_face(TriangleId triangle) noexcept
    {
        const TrianglePoint nearest = closest_point(mesh_.triangle(triangle), query_);
        const auto part = static_cast<std::size_t>(nearest.part);
        const TriangleCorners& corners = mesh_.triangles()[to_index(triangle)];
        if (part < 3) return try_vertex(VertexId{corners[part]});
        Candidate candidate;
        candidate.feature = {FeatureKind::face, to_index(triangle)};
        if (nearest.part != TrianglePart::inside)
            candidate.feature = {FeatureKind::edge, to_index(topology_.edges(triangle)[part - 3])};
        candidate.triangle = triangle;
        candidate.weights = nearest.weights;
        candidate.point = nearest.point;
        offer(candidate);
    }

    /// The nearest so far, nothing where the query is inside the mesh.
    [[nodiscard]] std::optional<ClosestFeature> result() const noexcept
    {
        if (!found_ || is_inside()) return std::nullopt;
        ClosestFeature answer;
        answer.feature = best_.feature;
        answer.triangle = faces_of(best_.feature).front();
        answer.point = best_.point;
        answer.squared_distance = best_.squared_distance;
        const TriangleCorners& corners = mesh_.triangles()[to_index(best_.triangle)];
        for (std::size_t i = 0; i < 3; ++i) {
            if (best_.weights[i] == 0) continue;
            const std::size_t corner = corner_of(answer.triangle, VertexId{corners[i]});
            answer.barycentric[corner] = best_.weights[i];
        }
        return answer;
    }

private:
    void offer(Candidate& candidate) noexcept
    {
        candidate.squared_distance = (query_ - candidate.point).squaredNorm();
        const bool is_nearer = !found_ || candidate.squared_distance < best_.squared_distance ||
                               (candidate.squared_distance == best_.squared_distance &&
                                candidate.feature < best_.feature);
        if (!is_nearer) return;
        best_ = candidate;
        found_ = true;
    }

    [[nodiscard]] std::size_t corner_of(TriangleId triangle, VertexId vertex) const noexcept
    {
        const TriangleCorners& corners = mesh_.triangles()[to_index(triangle)];
        return static_cast<std::size_t>(std::ranges::find(corners, to_index(vertex)) -
                                        corners.begin());
    }

    [[nodiscard]] std::span<const TriangleId> faces_of(const Feature& feature) const noexcept
    {
        switch (feature.kind) {
        case FeatureKind::vertex:
            return topology_.triangles(VertexId{feature.id});
        case FeatureKind::edge:
            return topology_.triangles(EdgeId{feature.id});
        case FeatureKind::face:
            break;
        }
        // The face itself, where an edge of it lists it.
        const auto both = topology_.triangles(topology_.edges(TriangleId{feature.id})[0]);
        return both.subspan(both.front() == TriangleId{feature.id} ? 0 : 1, 1);
    }

    /// Behind all faces of the nearest feature: of a point outside, the nearest one has a face
    /// before which it is.
    [[nodiscard]] bool is_inside() const noexcept
    {
        return std::ranges::none_of(faces_of(best_.feature), [&](TriangleId id) {
            const Triangle triangle = mesh_.triangle(id);
            return orient3d(triangle[0], triangle[1], triangle[2], query_) >= 0;
        });
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    const Vec3& query_;
    Candidate best_;
    bool found_ = false;
};

} // namespace

std::optional<ClosestFeature> closest_feature(const ThesisProximityOctree& octree,
                                              const TriangleMesh& mesh, const Topology& topology,
                                              const Vec3& point) noexcept
{
    PROXIMA_CHECK_EQ(octree.features().vertices, mesh.vertex_count());
    PROXIMA_CHECK_EQ(octree.features().edges, topology.edge_count());
    PROXIMA_CHECK_EQ(octree.features().faces, mesh.triangle_count());
    const auto cell = octree.locate(point);
    if (!cell) return std::nullopt;
    Search search(mesh, topology, point);
    for (const std::uint32_t id : octree.closest(*cell, FeatureKind::vertex))
        search.try_vertex(VertexId{id});
    for (const std::uint32_t id : octree.closest(*cell, FeatureKind::edge))
        search.try_edge(EdgeId{id});
    for (const std::uint32_t id : octree.closest(*cell, FeatureKind::face))
        search.try_face(TriangleId{id});
    return search.result();
}

} // namespace proxima
