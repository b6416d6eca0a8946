// Examines a surface: which of its triangles tell inside from outside, and by which normals.
#include "base/memory_budget.h"
#include "base/parallel.h"
#include "geometry/length.h"
#include "index/check_edges.h"
#include "index/index_parts.h"
#include "index/signs/sign_geometry.h"
#include "index/signs/sign_parts.h"
#include "index/signs/surface_sides.h"
#include "mesh/surface_parts.h"
#include "octree/winding_number.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t vertices_per_task = 1024;

/// Signs, and beside them for the time of the build the mesh, its topology and their scratch.
constexpr std::uint64_t bytes_per_triangle = 220;

/// Shorter sums do not point anywhere: the surface folds back on itself.
constexpr double shortest_sum = 1e-6;

/// The angle at the corner; 0 where a side has no length.
double angle_at(const Triangle& triangle, int corner) noexcept
{
    const Vec3 u = unit_of(triangle[(corner + 1) % 3] - triangle[corner]);
    const Vec3 v = unit_of(triangle[(corner + 2) % 3] - triangle[corner]);
    return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// The arrays of signs that were built.
struct SignStorage {
    std::vector<std::uint32_t> rows;
    std::vector<SurfaceSides> sides;
    std::vector<SurfaceSides> vertex_sides;
    std::vector<VertexSign> vertices;
    std::vector<std::uint32_t> edges;
    std::vector<std::uint32_t> edge_lists;
    WindingStorage winding;
};

class SignBuilder {
public:
    /// \pre mesh and topology are the index's
    SignBuilder(const IndexParts& index, const TriangleMesh& mesh, const Topology& topology)
        : index_(index), mesh_(mesh), topology_(topology)
    {
        stored_->rows.resize(index.triangle_count());
        for (std::uint32_t row = 0; row < index.triangle_count(); ++row)
            stored_->rows[to_index(index.id(row))] = row;
    }

    void take_winding(WindingStorage winding)
    {
        stored_->winding = std::move(winding);
        for (std::uint32_t& number : stored_->winding.order) number = stored_->rows[number];
        arrays_.winding = stored_->winding.view();
    }

    /// By triangle id. \pre winding numbers were taken
    void take_sides(std::span<const SurfaceSides> of_triangles, Threads threads)
    {
        stored_->sides.resize(of_triangles.size());
        double least = arrays_.least_height;
        for (std::uint32_t row = 0; row < of_triangles.size(); ++row) {
            const SurfaceSides sides = of_triangles[to_index(index_.id(row))];
            stored_->sides[row] = sides;
            if (sides != SurfaceSides::doubtful)
                least = std::min(least, height_of(index_.triangle(row), arrays_.winding.unit));
        }
        arrays_.least_height = least;
        // Winding numbers are whole, and 0 outside of the mesh's box.
        arrays_.bounds = bounding_box(mesh_);
        fill_vertices(threads);
        fill_edges();
    }

    [[nodiscard]] MeshIndex result()
    {
        arrays_.rows = stored_->rows;
        arrays_.sides = stored_->sides;
        arrays_.vertex_sides = stored_->vertex_sides;
        arrays_.vertices = stored_->vertices;
        arrays_.edges = stored_->edges;
        arrays_.edge_lists = stored_->edge_lists;
        return make_mesh_index(index_.adopt_signs(
            std::make_shared<const SignParts>(SignParts::adopt(arrays_, std::move(stored_)))));
    }

private:
    [[nodiscard]] bool is_proper(TriangleId id) const noexcept
    {
        return detail::is_proper(mesh_.triangles()[to_index(id)]);
    }

    void fill_vertices(Threads threads)
    {
        const std::size_t count = topology_.vertex_count();
        stored_->vertex_sides.assign(count, SurfaceSides::doubtful);
        stored_->vertices.resize(count);
        parallel_chunks(count, vertices_per_task, threads, [&](std::size_t first, std::size_t end) {
            for (std::size_t i = first; i < end; ++i) {
                fill_vertex(VertexId{static_cast<std::uint32_t>(i)});
            }
        });
    }

    void fill_vertex(VertexId vertex) noexcept
    {
        CommonSides common;
        Vec3 sum = Vec3::Zero();
        double least = std::numeric_limits<double>::infinity();
        for (const TriangleId id : topology_.triangles(vertex)) {
            if (!is_proper(id)) continue;
            common.add(stored_->sides[stored_->rows[to_index(id)]]);
            if (common.result() == SurfaceSides::doubtful) return;
            const Triangle triangle = mesh_.triangle(id);
            least = std::min(least, height_of(triangle, arrays_.winding.unit));
            if (common.result() != SurfaceSides::separates) continue;
            const TriangleCorners& corners = mesh_.triangles()[to_index(id)];
            const auto corner =
                static_cast<int>(std::ranges::find(corners, to_index(vertex)) - corners.begin());
            sum += angle_at(triangle, corner) * unit_normal_of(triangle);
        }
        const SurfaceSides sides = common.result();
        VertexSign sign;
        sign.least_height = least;
        if (sides == SurfaceSides::separates) {
            const double length = sum.norm();
            if (length < shortest_sum) return;
            const Vec3 normal = sum / length;
            sign.normal = {normal[0], normal[1], normal[2]};
        }
        if (sides == SurfaceSides::doubtful) return;
        stored_->vertex_sides[to_index(vertex)] = sides;
        stored_->vertices[to_index(vertex)] = sign;
    }

    void fill_edges()
    {
        stored_->edges.resize(topology_.edge_count());
        std::vector<std::uint32_t>& lists = stored_->edge_lists;
        for (std::uint32_t edge = 0; edge < topology_.edge_count(); ++edge) {
            const auto triangles = topology_.triangles(EdgeId{edge});
            if (triangles.size() == 2 && is_proper(triangles[0]) && is_proper(triangles[1])) {
                stored_->edges[edge] = stored_->rows[to_index(triangles[1])];
                continue;
            }
            const std::size_t first = lists.size();
            stored_->edges[edge] = edge_list_bit | static_cast<std::uint32_t>(first);
            lists.push_back(0);
            for (const TriangleId id : triangles) {
                if (!is_proper(id)) continue;
                lists.push_back(stored_->rows[to_index(id)]);
                ++lists[first];
            }
        }
    }

    const IndexParts& index_;
    const TriangleMesh& mesh_;
    const Topology& topology_;
    SignArrays arrays_;
    std::shared_ptr<SignStorage> stored_ = std::make_shared<SignStorage>();
};

} // namespace

Result<MeshIndex> with_signs(const MeshIndex& index, const SignOptions& options)
{
    const Execution& execution = options.execution;
    if (const Status status =
            check_budget(execution.budget, bytes_per_triangle * index.triangle_count(),
                         "signs of a mesh index", "raise the budget");
        !status)
        return tl::unexpected(status.error());
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto topology = build_topology(*mesh, {.execution = execution});
    if (!topology) return tl::unexpected(topology.error());
    if (const Status status = check_edges(index, *topology); !status)
        return tl::unexpected(status.error());
    auto winding = build_winding_number(*mesh, {.execution = execution});
    if (!winding) return tl::unexpected(winding.error());
    const auto sides = find_surface_sides(index, *mesh, *topology, {.execution = execution});
    if (!sides) return tl::unexpected(sides.error());

    SignBuilder builder(index.parts(), *mesh, *topology);
    builder.take_winding(std::move(*winding).release());
    if (!sides->empty()) builder.take_sides(*sides, execution.threads);
    return builder.result();
}

} // namespace proxima
