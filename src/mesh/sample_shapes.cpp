#include "mesh/sample_shapes.h"

#include "base/check.h"
#include "base/progress.h"
#include "mesh/unit_circle.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"

#include <cmath>
#include <utility>

namespace proxima {

namespace {

std::uint32_t id(std::size_t number) noexcept
{
    return static_cast<std::uint32_t>(number);
}

TriangleMesh checked(Result<TriangleMesh> mesh)
{
    PROXIMA_CHECK(mesh.has_value());
    return *std::move(mesh);
}

StageSteps making_mesh(Progress* progress, std::uint64_t triangles) noexcept
{
    return {progress, "making mesh", triangles};
}

// The order of operations is explicit, so that the bits do not depend on a vector library.
Vec3 on_unit_sphere(const Vec3& point) noexcept
{
    const double squared = point.x() * point.x() + point.y() * point.y() + point.z() * point.z();
    return point / std::sqrt(squared);
}

// Splits every triangle into four. New vertices follow the old ones in the order of the edges.
Result<TriangleMesh> subdivided_sphere(const TriangleMesh& mesh, Progress* progress)
{
    const Result<Topology> topology =
        build_topology(mesh, {.execution = {.threads = {1}, .progress = progress}});
    if (is_cancelled(progress)) return cancelled("making the mesh");
    PROXIMA_CHECK(topology.has_value());
    StageSteps steps = making_mesh(progress, 4 * mesh.triangle_count());
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    positions.reserve(positions.size() + topology->edge_count());
    for (std::uint32_t edge = 0; edge < topology->edge_count(); ++edge) {
        const auto [low, high] = topology->vertices(EdgeId{edge});
        positions.push_back(on_unit_sphere(mesh.position(low) + mesh.position(high)));
        if (!steps.done(1)) return cancelled("making the mesh");
    }
    std::vector<TriangleCorners> triangles;
    triangles.reserve(4 * mesh.triangle_count());
    for (std::uint32_t triangle = 0; triangle < mesh.triangle_count(); ++triangle) {
        const TriangleCorners corner = mesh.triangles()[triangle];
        TriangleCorners middle{};
        for (std::size_t side = 0; side < 3; ++side) {
            const EdgeId edge = topology->edges(TriangleId{triangle})[side];
            middle[side] = id(mesh.vertex_count() + to_index(edge));
        }
        triangles.push_back({corner[0], middle[0], middle[2]});
        triangles.push_back({corner[1], middle[1], middle[0]});
        triangles.push_back({corner[2], middle[2], middle[1]});
        triangles.push_back(middle);
        if (!steps.done(3)) return cancelled("making the mesh"); // an edge and a half were the rest
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace

namespace detail {

Result<TriangleMesh> sphere(int stacks, int slices, Progress* progress)
{
    PROXIMA_CHECK_GE(stacks, 2);
    PROXIMA_CHECK_GE(slices, 3);
    const auto rings = static_cast<std::uint32_t>(stacks) - 1;
    const auto count = static_cast<std::uint32_t>(slices);
    StageSteps steps = making_mesh(progress, std::uint64_t{3} * rings * count);
    std::vector<CirclePoint> meridian(count);
    for (std::uint32_t j = 0; j < count; ++j) {
        meridian[j] = unit_circle(j, count);
        if (!steps.done(1)) return cancelled("making the mesh");
    }

    std::vector<Vec3> positions;
    positions.reserve(2 + std::size_t{rings} * count);
    positions.emplace_back(0.0, 0.0, 1.0);
    for (std::uint32_t i = 1; i <= rings; ++i) {
        const CirclePoint latitude = unit_circle(i, 2 * (rings + 1));
        for (const CirclePoint& along : meridian) {
            positions.emplace_back(on_circle_grid(latitude.sine * along.cosine),
                                   on_circle_grid(latitude.sine * along.sine), latitude.cosine);
            if (!steps.done(1)) return cancelled("making the mesh");
        }
    }
    positions.emplace_back(0.0, 0.0, -1.0);

    const std::uint32_t bottom = 1 + rings * count;
    const auto vertex = [&](std::uint32_t ring, std::uint32_t slice) {
        return 1 + (ring - 1) * count + slice % count;
    };
    std::vector<TriangleCorners> triangles;
    triangles.reserve(std::size_t{2} * rings * count);
    for (std::uint32_t j = 0; j < count; ++j) {
        triangles.push_back({0, vertex(1, j), vertex(1, j + 1)});
    }
    for (std::uint32_t i = 1; i < rings; ++i) {
        for (std::uint32_t j = 0; j < count; ++j) {
            const std::uint32_t start = vertex(i, j);
            const std::uint32_t end = vertex(i + 1, j + 1);
            triangles.push_back({start, vertex(i + 1, j), end});
            triangles.push_back({start, end, vertex(i, j + 1)});
            if (!steps.done(2)) return cancelled("making the mesh");
        }
    }
    for (std::uint32_t j = 0; j < count; ++j) {
        triangles.push_back({vertex(rings, j), bottom, vertex(rings, j + 1)});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

Result<TriangleMesh> icosphere(int subdivisions, Progress* progress)
{
    PROXIMA_CHECK_GE(subdivisions, 0);
    PROXIMA_CHECK_LE(subdivisions, max_icosphere_subdivisions);
    const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
    // Vertices 4 a + 2 s + t: axis a is zero, the next +-1 (s), the one after +-golden (t).
    std::vector<Vec3> positions(12);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t signs = 0; signs < 4; ++signs) {
            Vec3 corner = Vec3::Zero();
            corner[static_cast<int>((axis + 1) % 3)] = signs / 2 == 0 ? 1.0 : -1.0;
            corner[static_cast<int>((axis + 2) % 3)] = signs % 2 == 0 ? golden : -golden;
            positions[4 * axis + signs] = on_unit_sphere(corner);
        }
    }
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t s = 0; s < 2; ++s) {
        for (std::uint32_t t = 0; t < 2; ++t) {
            for (std::uint32_t axis = 0; axis < 3; ++axis) {
                // The short edge (-1, +1) of this axis, and the two vertices beside it.
                const std::uint32_t plus = 4 * axis + t;
                const std::uint32_t minus = plus + 2;
                const std::uint32_t beside = 4 * ((axis + 1) % 3) + 2 * t + s;
                if (s == t) {
                    triangles.push_back({plus, minus, beside});
                } else {
                    triangles.push_back({minus, plus, beside});
                }
            }
            for (std::uint32_t u = 0; u < 2; ++u) {
                // One vertex of each axis, all three towards the octant of signs s, t, u.
                const TriangleCorners octant = {2 * t + u, 4 + 2 * u + s, 8 + 2 * s + t};
                triangles.push_back((s + t + u) % 2 == 0
                                        ? octant
                                        : TriangleCorners{octant[0], octant[2], octant[1]});
            }
        }
    }
    auto mesh = make_triangle_mesh(std::move(positions), std::move(triangles));
    for (int level = 0; level < subdivisions && mesh; ++level) {
        mesh = subdivided_sphere(*mesh, progress);
    }
    return mesh;
}

Result<TriangleMesh> torus(int around, int across, Progress* progress)
{
    PROXIMA_CHECK_GE(around, 3);
    PROXIMA_CHECK_GE(across, 3);
    const auto columns = static_cast<std::uint32_t>(around);
    const auto rows = static_cast<std::uint32_t>(across);
    StageSteps steps = making_mesh(progress, std::uint64_t{2} * columns * rows);
    std::vector<CirclePoint> tube(rows);
    for (std::uint32_t j = 0; j < rows; ++j) {
        tube[j] = unit_circle(j, rows);
        if (!steps.done(1)) return cancelled("making the mesh");
    }

    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    positions.reserve(std::size_t{columns} * rows);
    triangles.reserve(std::size_t{2} * columns * rows);
    for (std::uint32_t i = 0; i < columns; ++i) {
        const CirclePoint ring = unit_circle(i, columns);
        const std::uint32_t here = i * rows;
        const std::uint32_t next = (i + 1) % columns * rows;
        for (std::uint32_t j = 0; j < rows; ++j) {
            const double radius = 1.0 + 0.5 * tube[j].cosine;
            positions.emplace_back(radius * ring.cosine, radius * ring.sine, 0.5 * tube[j].sine);
            const std::uint32_t up = (j + 1) % rows;
            triangles.push_back({here + j, next + j, next + up});
            triangles.push_back({here + j, next + up, here + up});
            if (!steps.done(2)) return cancelled("making the mesh");
        }
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace detail

TriangleMesh make_sphere(int stacks, int slices)
{
    return checked(detail::sphere(stacks, slices, nullptr));
}

TriangleMesh make_icosphere(int subdivisions)
{
    return checked(detail::icosphere(subdivisions, nullptr));
}

TriangleMesh make_torus(int around, int across)
{
    return checked(detail::torus(around, across, nullptr));
}

TriangleMesh make_cube()
{
    std::vector<Vec3> positions;
    for (unsigned corner = 0; corner < 8; ++corner) {
        positions.emplace_back((corner & 1U) != 0 ? 1.0 : -1.0, (corner & 2U) != 0 ? 1.0 : -1.0,
                               (corner & 4U) != 0 ? 1.0 : -1.0);
    }
    return checked(make_triangle_mesh(std::move(positions), {{0, 2, 3},
                                                             {0, 3, 1},
                                                             {4, 5, 7},
                                                             {4, 7, 6},
                                                             {0, 1, 5},
                                                             {0, 5, 4},
                                                             {2, 6, 7},
                                                             {2, 7, 3},
                                                             {0, 4, 6},
                                                             {0, 6, 2},
                                                             {1, 3, 7},
                                                             {1, 7, 5}}));
}

TriangleMesh make_octahedron()
{
    std::vector<Vec3> positions = {Vec3(1, 0, 0),  Vec3(-1, 0, 0), Vec3(0, 1, 0),
                                   Vec3(0, -1, 0), Vec3(0, 0, 1),  Vec3(0, 0, -1)};
    return checked(make_triangle_mesh(
        std::move(positions),
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}));
}

} // namespace proxima
