// Meshes and indexes of the C interface.
#include "c/handles.h"
#include "proxima/index_io.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace {

using namespace proxima;
using namespace proxima::c;

proxima_status give(Result<TriangleMesh> made, proxima_mesh** mesh)
{
    if (!made) return failed(made.error());
    *mesh = new proxima_mesh{std::move(*made)};
    return PROXIMA_OK;
}

proxima_status give(const Result<MeshIndex>& made, proxima_index** index)
{
    if (!made) return failed(made.error());
    *index = new proxima_index{*made};
    return PROXIMA_OK;
}

// Checked before the arrays are copied, as the library does after.

proxima_status check_vertices(std::size_t count) noexcept
{
    return check_count(count, std::numeric_limits<std::uint32_t>::max() - 1,
                       "a mesh has at most 2^32 - 2 vertices");
}

proxima_status check_elements(std::size_t count, const char* limit) noexcept
{
    return check_count(count, std::numeric_limits<std::int32_t>::max(), limit);
}

constexpr std::uint32_t all_additions = PROXIMA_LISTS | PROXIMA_SLABS | PROXIMA_SIGNS;

Result<MeshIndex> build(const TriangleMesh& mesh, std::uint32_t additions,
                        const Execution& execution)
{
    Result<MeshIndex> index = build_mesh_index(mesh, {.execution = execution});
    if (index && (additions & PROXIMA_SLABS) != 0)
        index = with_slabs(*index, {.execution = execution});
    if (index && (additions & PROXIMA_SIGNS) != 0)
        index = with_signs(*index, {.execution = execution});
    if (index && (additions & PROXIMA_LISTS) != 0)
        index = with_lists(*index, {.execution = execution});
    return index;
}

} // namespace

proxima_status proxima_mesh_create(const double* vertices, size_t vertex_count,
                                   const uint32_t* triangles, size_t triangle_count,
                                   proxima_mesh** mesh)
{
    if (any_null(mesh)) return PROXIMA_INVALID_ARGUMENT;
    if (vertex_count > 0 && any_null(vertices)) return PROXIMA_INVALID_ARGUMENT;
    if (triangle_count > 0 && any_null(triangles)) return PROXIMA_INVALID_ARGUMENT;
    if (const auto status = check_vertices(vertex_count); status != PROXIMA_OK) return status;
    if (const auto status = check_elements(triangle_count, "a mesh has at most 2^31 - 1 triangles");
        status != PROXIMA_OK)
        return status;
    return guarded([&] {
        const auto points = points_of(vertices, vertex_count);
        std::vector<Vec3> positions(points.begin(), points.end());
        std::vector<TriangleCorners> corners(triangle_count);
        for (std::size_t i = 0; i < triangle_count; ++i)
            corners[i] = {triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]};
        return give(make_triangle_mesh(std::move(positions), std::move(corners)), mesh);
    });
}

proxima_status proxima_mesh_of_points(const double* points, size_t point_count, proxima_mesh** mesh)
{
    if (any_null(mesh)) return PROXIMA_INVALID_ARGUMENT;
    if (point_count > 0 && any_null(points)) return PROXIMA_INVALID_ARGUMENT;
    if (const auto status = check_elements(point_count, "a mesh has at most 2^31 - 1 points");
        status != PROXIMA_OK)
        return status;
    return guarded([&] {
        const auto given = points_of(points, point_count);
        return give(mesh_of_points({given.begin(), given.end()}), mesh);
    });
}

proxima_status proxima_mesh_of_segments(const double* points, size_t point_count,
                                        const uint32_t* segments, size_t segment_count,
                                        proxima_mesh** mesh)
{
    if (any_null(mesh)) return PROXIMA_INVALID_ARGUMENT;
    if (point_count > 0 && any_null(points)) return PROXIMA_INVALID_ARGUMENT;
    if (segment_count > 0 && any_null(segments)) return PROXIMA_INVALID_ARGUMENT;
    if (const auto status = check_vertices(point_count); status != PROXIMA_OK) return status;
    if (const auto status = check_elements(segment_count, "a mesh has at most 2^31 - 1 segments");
        status != PROXIMA_OK)
        return status;
    return guarded([&] {
        const auto given = points_of(points, point_count);
        std::vector<std::array<std::uint32_t, 2>> ends(segment_count);
        for (std::size_t i = 0; i < segment_count; ++i)
            ends[i] = {segments[2 * i], segments[2 * i + 1]};
        return give(mesh_of_segments({given.begin(), given.end()}, ends), mesh);
    });
}

proxima_status proxima_mesh_read(const char* path, proxima_mesh** mesh)
{
    if (any_null(path, mesh)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return give(read_mesh(path), mesh); });
}

proxima_status proxima_mesh_write(const proxima_mesh* mesh, const char* path)
{
    if (any_null(mesh, path)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return status_of(write_mesh(mesh->mesh, path)); });
}

proxima_status proxima_mesh_sample(const char* name, proxima_mesh** mesh)
{
    if (any_null(name, mesh)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return give(sample_mesh(name), mesh); });
}

void proxima_mesh_destroy(proxima_mesh* mesh)
{
    delete mesh;
}

size_t proxima_mesh_vertex_count(const proxima_mesh* mesh)
{
    return mesh != nullptr ? mesh->mesh.vertex_count() : 0;
}

size_t proxima_mesh_triangle_count(const proxima_mesh* mesh)
{
    return mesh != nullptr ? mesh->mesh.triangle_count() : 0;
}

const double* proxima_mesh_vertices(const proxima_mesh* mesh)
{
    return mesh != nullptr && mesh->mesh.vertex_count() > 0 ? mesh->mesh.positions()[0].data()
                                                            : nullptr;
}

const uint32_t* proxima_mesh_triangles(const proxima_mesh* mesh)
{
    return mesh != nullptr && mesh->mesh.triangle_count() > 0 ? mesh->mesh.triangles()[0].data()
                                                              : nullptr;
}

proxima_status proxima_mesh_bounds(const proxima_mesh* mesh, double lower[3], double upper[3])
{
    if (any_null(mesh, lower, upper)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<Box> box = checked_bounding_box(mesh->mesh);
        if (!box) return failed(box.error());
        copy_to(lower, box->lower);
        copy_to(upper, box->upper);
        return PROXIMA_OK;
    });
}

proxima_status proxima_index_build(const proxima_mesh* mesh, uint32_t additions,
                                   const proxima_execution* execution, proxima_index** index)
{
    if (any_null(mesh, index)) return PROXIMA_INVALID_ARGUMENT;
    if ((additions & ~all_additions) != 0)
        return refused("additions: not a sum of PROXIMA_LISTS, PROXIMA_SLABS and PROXIMA_SIGNS");
    const std::optional<Execution> how = execution_of(execution);
    if (!how) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return give(build(mesh->mesh, additions, *how), index); });
}

proxima_status proxima_index_save(const proxima_index* index, const char* path)
{
    if (any_null(index, path)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return status_of(save_index(index->index, path)); });
}

proxima_status proxima_index_load(const char* path, proxima_index** index)
{
    if (any_null(path, index)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return give(load_index(path), index); });
}

void proxima_index_destroy(proxima_index* index)
{
    delete index;
}

proxima_status proxima_index_mesh(const proxima_index* index, proxima_mesh** mesh)
{
    if (any_null(index, mesh)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return give(mesh_of(index->index), mesh); });
}

uint32_t proxima_index_triangle_count(const proxima_index* index)
{
    return index != nullptr ? index->index.triangle_count() : 0;
}

uint32_t proxima_index_additions(const proxima_index* index)
{
    if (index == nullptr) return 0;
    std::uint32_t additions = 0;
    if (index->index.has_lists()) additions |= PROXIMA_LISTS;
    if (index->index.has_slabs()) additions |= PROXIMA_SLABS;
    if (index->index.has_signs()) additions |= PROXIMA_SIGNS;
    return additions;
}

uint64_t proxima_index_bytes(const proxima_index* index)
{
    return index != nullptr ? index->index.bytes() : 0;
}
