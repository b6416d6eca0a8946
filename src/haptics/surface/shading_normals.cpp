#include "haptics/surface/shading_normals.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "haptics/surface/swept_sphere.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

std::size_t corner_of(const TriangleCorners& corners, VertexId vertex)
{
    for (std::size_t k = 0; k < 2; ++k) {
        if (corners[k] == to_index(vertex)) return k;
    }
    return 2;
}

double angle_at(const Triangle& triangle, std::size_t corner)
{
    const auto k = static_cast<int>(corner);
    const Vec3 a = triangle[(k + 1) % 3] - triangle[k];
    const Vec3 b = triangle[(k + 2) % 3] - triangle[k];
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// The triangles round one vertex, split at its sharp edges.
class Fans {
public:
    Fans(const TriangleMesh& mesh, const Topology& topology, const std::vector<Vec3>& faces,
         double least_cosine)
        : mesh_(mesh), topology_(topology), faces_(faces), least_cosine_(least_cosine)
    {}

    /// Writes the mean normal of each triangle's fan at the vertex.
    void write(VertexId vertex, std::vector<std::array<Vec3, 3>>& corners)
    {
        const auto star = topology_.triangles(vertex);
        fan_.resize(star.size());
        for (std::size_t i = 0; i < star.size(); ++i) fan_[i] = i;
        for (const EdgeId edge : topology_.edges(vertex)) join_across(edge, star);
        for (std::size_t i = 0; i < star.size(); ++i) {
            const std::size_t corner = corner_in(star[i], vertex);
            corners[to_index(star[i])][corner] = mean_of(fan_[i], star, vertex, star[i]);
        }
    }

private:
    [[nodiscard]] std::size_t corner_in(TriangleId triangle, VertexId vertex) const
    {
        return corner_of(mesh_.triangles()[to_index(triangle)], vertex);
    }

    void join_across(EdgeId edge, std::span<const TriangleId> star)
    {
        const auto sides = topology_.triangles(edge);
        if (sides.size() != 2) return;
        if (!(faces_[to_index(sides[0])].dot(faces_[to_index(sides[1])]) >= least_cosine_)) return;
        const auto rank = [&](TriangleId id) {
            return static_cast<std::size_t>(std::ranges::lower_bound(star, id) - star.begin());
        };
        const std::size_t kept = fan_[rank(sides[0])];
        const std::size_t joined = fan_[rank(sides[1])];
        std::ranges::replace(fan_, joined, kept);
    }

    /// The mean normal of a fan; the triangle's own where the mean is far from one of its faces.
    [[nodiscard]] Vec3 mean_of(std::size_t fan, std::span<const TriangleId> star, VertexId vertex,
                               TriangleId self) const
    {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 0; i < star.size(); ++i) {
            if (fan_[i] != fan) continue;
            sum += angle_at(mesh_.triangle(star[i]), corner_in(star[i], vertex)) *
                   faces_[to_index(star[i])];
        }
        const double length = sum.norm();
        if (!(length > 0)) return faces_[to_index(self)];
        constexpr double least = 0.25;
        for (std::size_t i = 0; i < star.size(); ++i) {
            if (fan_[i] == fan && sum.dot(faces_[to_index(star[i])]) < least * length)
                return faces_[to_index(self)];
        }
        return sum / length;
    }

    const TriangleMesh& mesh_;
    const Topology& topology_;
    const std::vector<Vec3>& faces_;
    double least_cosine_;
    std::vector<std::size_t> fan_; ///< of each triangle of the star
};

} // namespace

ShadingNormals::ShadingNormals(const TriangleMesh& mesh, const Topology& topology,
                               const ShadingOptions& options)
    : mesh_(mesh), corners_(mesh.triangle_count())
{
    std::vector<Vec3> faces(mesh.triangle_count());
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        faces[id] = unit_normal(mesh.triangle(TriangleId{id}));
        corners_[id].fill(faces[id]);
    }
    Fans fans(mesh, topology, faces, std::cos(options.sharp_angle));
    for (std::uint32_t id = 0; id < mesh.vertex_count(); ++id) fans.write(VertexId{id}, corners_);
}

Vec3 ShadingNormals::shaded_normal(TriangleId triangle, const Vec3& point) const noexcept
{
    const TrianglePoint at = closest_point(mesh_.triangle(triangle), point);
    const std::array<Vec3, 3>& corners = corners_[to_index(triangle)];
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) sum += at.weights[k] * corners[k];
    const double length = sum.norm();
    if (!(length > 0)) return Vec3::Zero();
    return sum / length;
}

} // namespace proxima
