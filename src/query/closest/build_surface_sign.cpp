// Examines a surface: which of its triangles tell inside from outside, and by which normals.
#include "base/parallel.h"
#include "mesh/surface_parts.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"
#include "query/closest/sign_geometry.h"
#include "query/closest/sign_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t vertices_per_task = 1024;

/// Shorter sums do not point anywhere: the surface folds back on itself.
constexpr double shortest_sum = 1e-6;

/// The angle at the corner; 0 where a side has no length.
double angle_at(const Triangle& triangle, int corner) noexcept
{
    const Vec3 u = (triangle[(corner + 1) % 3] - triangle[corner]).stableNormalized();
    const Vec3 v = (triangle[(corner + 2) % 3] - triangle[corner]).stableNormalized();
    return std::atan2(u.cross(v).norm(), u.dot(v));
}

} // namespace

// The steps of build_surface_sign.
class SurfaceSignBuilder {
public:
    SurfaceSignBuilder(std::shared_ptr<const TriangleMesh> mesh,
                       std::shared_ptr<const Topology> topology, WindingNumber winding,
                       std::vector<SurfaceSides> sides)
    {
        sign_.mesh_ = std::move(mesh);
        sign_.topology_ = std::move(topology);
        sign_.winding_ = std::move(winding);
        sign_.sides_ = std::move(sides);
        const std::size_t vertices = sign_.mesh().vertex_count();
        sign_.vertex_sides_.assign(vertices, SurfaceSides::doubtful);
        const auto separate =
            std::ranges::find(sign_.sides_, SurfaceSides::separates) != sign_.sides_.end();
        if (separate) sign_.pseudonormals_.assign(vertices, Vec3::Zero());
    }

    /// Of the triangles that tell: where there are any, winding numbers are whole, and 0 outside of
    /// the mesh's box.
    void measure() noexcept
    {
        const TriangleMesh& mesh = sign_.mesh();
        constexpr double infinity = std::numeric_limits<double>::infinity();
        double least = infinity;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            if (sign_.sides_[i] == SurfaceSides::doubtful) continue;
            least =
                std::min(least, height_of(mesh.triangle(TriangleId{i}), sign_.winding().unit()));
        }
        sign_.least_height_ = least;
        sign_.bounds_ = least < infinity ? bounding_box(mesh)
                                         : Box{Vec3::Constant(-infinity), Vec3::Constant(infinity)};
    }

    void fill_vertices(Threads threads)
    {
        const std::size_t count = sign_.vertex_sides_.size();
        parallel_for((count + vertices_per_task - 1) / vertices_per_task, threads,
                     [&](std::size_t task) {
                         const std::size_t end = std::min(count, (task + 1) * vertices_per_task);
                         for (std::size_t i = task * vertices_per_task; i < end; ++i) {
                             fill_vertex(VertexId{static_cast<std::uint32_t>(i)});
                         }
                     });
    }

    [[nodiscard]] SurfaceSign result()
    {
        return SurfaceSign(std::make_shared<const SignParts>(std::move(sign_)));
    }

private:
    void fill_vertex(VertexId vertex) noexcept
    {
        const TriangleMesh& mesh = sign_.mesh();
        CommonSides common;
        Vec3 sum = Vec3::Zero();
        for (const TriangleId id : sign_.topology_->triangles(vertex)) {
            const TriangleCorners& corners = mesh.triangles()[to_index(id)];
            if (!detail::is_proper(corners)) continue;
            common.add(sign_.sides_[to_index(id)]);
            if (common.result() != SurfaceSides::separates) continue;
            const auto corner =
                static_cast<int>(std::ranges::find(corners, to_index(vertex)) - corners.begin());
            const Triangle triangle = mesh.triangle(id);
            sum += angle_at(triangle, corner) * unit_normal_of(triangle);
        }
        SurfaceSides& sides = sign_.vertex_sides_[to_index(vertex)];
        sides = common.result();
        if (sides != SurfaceSides::separates) return;
        const double length = sum.norm();
        if (length < shortest_sum) {
            sides = SurfaceSides::doubtful;
        } else {
            sign_.pseudonormals_[to_index(vertex)] = sum / length;
        }
    }

    SignParts sign_;
};

namespace {

using SharedMesh = std::shared_ptr<const TriangleMesh>;
using SharedTopology = std::shared_ptr<const Topology>;

Result<SurfaceSign> build(SharedMesh mesh, SharedTopology topology, const MeshIndex& index,
                          const Execution& execution)
{
    auto winding = build_winding_number(*mesh, {.execution = execution});
    if (!winding) return tl::unexpected(winding.error());
    auto sides = find_surface_sides(index, *topology, *winding, {.execution = execution});
    if (!sides) return tl::unexpected(sides.error());
    SurfaceSignBuilder builder(std::move(mesh), std::move(topology), std::move(*winding),
                               std::move(*sides));
    builder.fill_vertices(execution.threads);
    builder.measure();
    return builder.result();
}

/// To what somebody else keeps.
template <class T>
std::shared_ptr<const T> refer_to(const T& kept)
{
    return {std::shared_ptr<const void>(), &kept};
}

} // namespace

Result<SurfaceSign> build_surface_sign(const MeshIndex& index, const SurfaceSignOptions& options)
{
    auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    auto topology = build_topology(*mesh, {.execution = options.execution});
    if (!topology) return tl::unexpected(topology.error());
    return build(std::make_shared<const TriangleMesh>(std::move(*mesh)),
                 std::make_shared<const Topology>(std::move(*topology)), index, options.execution);
}

Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh, const Topology& topology,
                                       const MeshIndex& index, const SurfaceSignOptions& options)
{
    return build(refer_to(mesh), refer_to(topology), index, options.execution);
}

Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh, const Topology& topology,
                                       const SurfaceSignOptions& options)
{
    const auto index = build_mesh_index(mesh, {.execution = options.execution});
    if (!index) return tl::unexpected(index.error());
    return build_surface_sign(mesh, topology, *index, options);
}

} // namespace proxima
