#include "index/lists/local_features.h"

#include "base/progress.h"
#include "geometry/exact_predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// Bounds on what the conversion to the frame and a few roundings do to a direction, by the length
/// that it is computed from. Coordinates are below 2 in size.
constexpr double direction_error = 0x1p-49;

/// No point of the root is farther from one of the mesh.
constexpr double largest_distance = 4.0;

/// Beyond this margin a plane is not worth keeping.
constexpr double largest_margin = 0x1p-10;

class FeatureCollector {
public:
    FeatureCollector(const TriangleMesh& mesh, const Topology& topology,
                     std::span<const TriangleId> order, const RootFrame& frame)
        : mesh_(mesh), topology_(topology), order_(order), rank_(order.size())
    {
        for (std::uint32_t rank = 0; rank < order.size(); ++rank)
            rank_[to_index(order[rank])] = rank;
        positions_.reserve(mesh.vertex_count());
        for (const Vec3& position : mesh.positions())
            positions_.push_back(frame.to_frame(position));
    }

    std::optional<LocalFeatures> collect(Progress* progress)
    {
        std::vector<bool> edge_seen(topology_.edge_count());
        std::vector<bool> vertex_seen(topology_.vertex_count());
        result_.features.reserve(order_.size() * 3);
        StageSteps steps(progress, "local regions", order_.size());
        for (const TriangleId triangle : order_) {
            add_face(triangle);
            for (const EdgeId edge : topology_.edges(triangle)) {
                if (edge == no_edge || edge_seen[to_index(edge)]) continue;
                edge_seen[to_index(edge)] = true;
                add_edge(edge);
            }
            for (const std::uint32_t vertex : mesh_.triangles()[to_index(triangle)]) {
                if (vertex_seen[vertex]) continue;
                vertex_seen[vertex] = true;
                add_vertex(VertexId{vertex});
            }
            if (!steps.done(1)) return std::nullopt;
        }
        return std::move(result_);
    }

private:
    /// A triangle's plane, as far as it has one.
    struct Face {
        Vec3 normal = Vec3::Zero();
        double error = 0; ///< of the normal's direction; infinite without a normal
    };

    [[nodiscard]] const Vec3& at(std::uint32_t vertex) const { return positions_[vertex]; }

    [[nodiscard]] Face face_of(TriangleId triangle) const
    {
        const TriangleCorners& v = mesh_.triangles()[to_index(triangle)];
        const Vec3 ab = at(v[1]) - at(v[0]);
        const Vec3 ac = at(v[2]) - at(v[0]);
        const Vec3 bc = at(v[2]) - at(v[1]);
        const Vec3 normal = ab.cross(ac);
        const double area = normal.norm();
        const double longest = std::max({ab.norm(), ac.norm(), bc.norm()});
        const double error = 4 * direction_error * longest / area;
        if (!(error < largest_margin))
            return {Vec3::Zero(), std::numeric_limits<double>::infinity()};
        return {normal / area, error};
    }

    /// The normal, in the triangle's plane, of its side from vertex a to b, away from the triangle.
    void add_side_plane(const Face& face, std::uint32_t a, std::uint32_t b, double sign)
    {
        const Vec3 side = at(b) - at(a);
        const double length = side.norm();
        if (!(length > 0)) return;
        const Vec3 outward = (side / length).cross(face.normal);
        add_plane(sign * outward, at(a), face.error + direction_error / length);
    }

    /// The points x with normal . (x - p) <= 0, and some more for all errors.
    void add_plane(const Vec3& normal, const Vec3& p, double error)
    {
        const double margin = largest_distance * error;
        if (!(margin < largest_margin)) return;
        for (int axis = 0; axis < 3; ++axis)
            result_.numbers.push_back(static_cast<float>(normal[axis]));
        result_.numbers.push_back(
            static_cast<float>(normal.dot(p) + margin + static_cast<double>(float_margin)));
        ++feature_.planes;
    }

    /// The points not beyond `place` on the way from one vertex to another.
    void add_end_plane(std::uint32_t from, std::uint32_t to, std::uint32_t place)
    {
        const Vec3 along = at(to) - at(from);
        const double length = along.norm();
        if (length > 0) add_plane(along / length, at(place), direction_error / length);
    }

    void begin(FeatureKind kind)
    {
        feature_ = {};
        feature_.kind = kind;
        feature_.numbers = static_cast<std::uint32_t>(result_.numbers.size());
        feature_.incident = static_cast<std::uint32_t>(result_.incident.size());
    }

    void add_point(const Vec3& p)
    {
        for (int axis = 0; axis < 3; ++axis) result_.numbers.push_back(static_cast<float>(p[axis]));
    }

    void end(std::span<const TriangleId> triangles)
    {
        for (const TriangleId triangle : triangles)
            result_.incident.push_back(rank_[to_index(triangle)]);
        feature_.incident_count = static_cast<std::uint32_t>(triangles.size());
        std::sort(result_.incident.begin() + feature_.incident, result_.incident.end());
        result_.features.push_back(feature_);
    }

    void add_face(TriangleId triangle)
    {
        const Face face = face_of(triangle);
        if (!std::isfinite(face.error)) return add_sliver(triangle);
        const TriangleCorners& v = mesh_.triangles()[to_index(triangle)];
        begin(FeatureKind::face);
        for (std::size_t i = 0; i < 3; ++i) add_side_plane(face, v[i], v[(i + 1) % 3], 1.0);
        feature_.flat = feature_.planes == 3 && face.error < 0x1p-24;
        const Eigen::Vector3f normal = face.normal.cast<float>();
        const Vec3 used = normal.cast<double>();
        std::array<double, 3> heights{};
        for (std::size_t i = 0; i < 3; ++i) heights[i] = used.dot(at(v[i]));
        const auto [low, high] = std::ranges::minmax(heights);
        for (int axis = 0; axis < 3; ++axis) result_.numbers.push_back(normal[axis]);
        result_.numbers.push_back(static_cast<float>(low));
        result_.numbers.push_back(static_cast<float>(high));
        for (const std::uint32_t vertex : v) add_point(at(vertex));
        end(std::array{triangle});
    }

    /// A triangle whose normal says nothing, as its longest side: feet of points in it are between the
    /// ends of that side, and its height is far less than the errors of floats. One that is a point in
    /// the frame has sides, too: of no length.
    void add_sliver(TriangleId triangle)
    {
        if (is_degenerate(mesh_.triangle(triangle))) return;
        const TriangleCorners& v = mesh_.triangles()[to_index(triangle)];
        std::array<std::uint32_t, 2> ends{v[0], v[1]};
        double longest = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double squared = (at(v[(i + 1) % 3]) - at(v[i])).squaredNorm();
            if (squared > longest) longest = squared, ends = {v[i], v[(i + 1) % 3]};
        }
        begin(FeatureKind::edge);
        add_end_plane(ends[1], ends[0], ends[0]);
        add_end_plane(ends[0], ends[1], ends[1]);
        for (const std::uint32_t end : ends) add_point(at(end));
        end(std::array{triangle});
    }

    void add_edge(EdgeId edge)
    {
        const auto [low, high] = topology_.vertices(edge);
        begin(FeatureKind::edge);
        add_end_plane(to_index(high), to_index(low), to_index(low));
        add_end_plane(to_index(low), to_index(high), to_index(high));
        std::uint32_t faces = 0;
        for (const TriangleId triangle : topology_.triangles(edge)) {
            if (faces == max_edge_faces) break;
            const Face face = face_of(triangle);
            if (!std::isfinite(face.error)) continue;
            ++faces;
            const TriangleCorners& v = mesh_.triangles()[to_index(triangle)];
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = v[i];
                const std::uint32_t b = v[(i + 1) % 3];
                if ((a == to_index(low) && b == to_index(high)) ||
                    (a == to_index(high) && b == to_index(low))) {
                    add_side_plane(face, a, b, -1.0);
                    break;
                }
            }
        }
        add_point(at(to_index(low)));
        add_point(at(to_index(high)));
        end(topology_.triangles(edge));
    }

    void add_vertex(VertexId vertex)
    {
        begin(FeatureKind::vertex);
        const std::span<const EdgeId> edges = topology_.edges(vertex);
        // Of very many neighbours some, evenly spread over their list.
        const std::size_t stride = (edges.size() + max_vertex_planes - 1) / max_vertex_planes;
        for (std::size_t i = 0; i < edges.size(); i += std::max<std::size_t>(stride, 1)) {
            add_end_plane(to_index(vertex), to_index(topology_.other_end(edges[i], vertex)),
                          to_index(vertex));
        }
        add_point(at(to_index(vertex)));
        end(topology_.triangles(vertex));
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    std::span<const TriangleId> order_;
    std::vector<std::uint32_t> rank_;
    std::vector<Vec3> positions_;
    LocalFeatures result_;
    LocalFeature feature_;
};

} // namespace

std::uint64_t LocalFeatures::bytes() const noexcept
{
    return std::span(features).size_bytes() + std::span(numbers).size_bytes() +
           std::span(incident).size_bytes();
}

std::optional<LocalFeatures> collect_local_features(const TriangleMesh& mesh,
                                                    const Topology& topology,
                                                    std::span<const TriangleId> order,
                                                    const RootFrame& frame, Progress* progress)
{
    return FeatureCollector(mesh, topology, order, frame).collect(progress);
}

} // namespace proxima
