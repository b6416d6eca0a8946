#include "mesh/io/mesh_assembler.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "mesh/triangulate_polygon.h"
#include "mesh/weld_vertices.h"

#include <algorithm>
#include <array>
#include <limits>

namespace proxima::detail {

namespace {

constexpr std::uint64_t vertex_limit = std::numeric_limits<std::uint32_t>::max() - 1;
constexpr std::uint64_t triangle_limit = std::numeric_limits<std::int32_t>::max();

} // namespace

bool MeshAssembler::reserve_vertices(std::uint64_t count)
{
    if (count > vertex_limit || positions_.size() + count > 2 * vertex_limit) {
        error_ = {ErrorCode::limit_exceeded,
                  concat("a mesh has at most 2^32 - 2 vertices, this one has ",
                         positions_.size() + count, " or more: split it"),
                  source_.name};
        return false;
    }
    if (!fits_budget((positions_.size() + count) * sizeof(Vec3))) return false;
    positions_.reserve(positions_.size() + count);
    return true;
}

bool MeshAssembler::reserve_triangles(std::uint64_t count)
{
    if (count > triangle_limit || triangles_.size() + count > 2 * triangle_limit) {
        error_ = {ErrorCode::limit_exceeded,
                  concat("a mesh has at most 2^31 - 1 triangles, this one has ",
                         triangles_.size() + count, " or more: split it"),
                  source_.name};
        return false;
    }
    if (!fits_budget((triangles_.size() + count) * sizeof(TriangleCorners))) return false;
    triangles_.reserve(triangles_.size() + count);
    return true;
}

bool MeshAssembler::add_points_of_vertices()
{
    if (!reserve_triangles(positions_.size())) return false;
    for (std::uint32_t vertex = 0; vertex < positions_.size(); ++vertex)
        triangles_.push_back({vertex, vertex, vertex});
    return true;
}

bool MeshAssembler::reserve_welded(std::size_t more)
{
    const std::uint64_t needed = welded_.size() + more;
    if (needed > welded_.capacity()) {
        // The old and the new table exist together while one is copied.
        const std::uint64_t vertices = std::max<std::uint64_t>(needed, 2 * welded_.capacity());
        if (!fits_budget(VertexTable::bytes_for(vertices))) return false;
        welded_.reserve(vertices);
    }
    return needed <= positions_.capacity() ||
           reserve_vertices(std::max<std::uint64_t>(more, growth(positions_)));
}

bool MeshAssembler::add_welded(std::span<const Vec3> positions, std::span<std::uint32_t> ids)
{
    if (!reserve_welded(positions.size())) return false;
    std::array<std::uint64_t, weld_block> hashes{};
    for (std::size_t i = 0; i < positions.size(); ++i) {
        hashes[i] = VertexTable::hash(positions[i]);
        welded_.prefetch(hashes[i]);
    }
    for (std::size_t i = 0; i < positions.size(); ++i) {
        ids[i] = welded_.find_or_add(hashes[i], positions[i], positions_.data());
        if (ids[i] == positions_.size()) positions_.push_back(positions[i]);
    }
    return true;
}

bool MeshAssembler::add_polygon(std::span<const std::uint32_t> corners)
{
    if (polygons_.size() == polygons_.capacity()) {
        const std::uint64_t size = polygons_.size() + growth(polygons_);
        if (!fits_budget(size * sizeof(Polygon))) return false;
        polygons_.reserve(size);
    }
    const std::uint64_t needed = triangles_.size() + corners.size() - 2;
    if (needed > triangles_.capacity() &&
        !reserve_triangles(std::max<std::uint64_t>(corners.size() - 2, growth(triangles_)))) {
        return false;
    }
    polygons_.push_back({static_cast<std::uint32_t>(triangles_.size()),
                         static_cast<std::uint32_t>(corners.size())});
    for (std::size_t i = 2; i < corners.size(); ++i) {
        triangles_.push_back({corners[0], corners[i - 1], corners[i]});
    }
    return true;
}

// While an array grows, the file, the old arrays and the new array exist together.
bool MeshAssembler::fits_budget(std::uint64_t more_bytes)
{
    const std::uint64_t needed = source_.text.size() + positions_.capacity() * sizeof(Vec3) +
                                 triangles_.capacity() * sizeof(TriangleCorners) +
                                 polygons_.capacity() * sizeof(Polygon) +
                                 (welded_.size() > 0 ? welded_.bytes() : 0) + more_bytes;
    auto status = check_budget(options_.execution.budget, needed, "reading " + source_.name,
                               "raise the budget or decimate the mesh");
    if (!status) error_ = std::move(status.error());
    return status.has_value();
}

Status MeshAssembler::cut_polygons()
{
    PolygonTriangulator triangulator;
    std::vector<std::uint32_t> corners;
    for (std::size_t polygon = 0; polygon < polygons_.size(); ++polygon) {
        const auto [first, count] = polygons_[polygon];
        const auto fan = std::span(triangles_).subspan(first, count - 2);
        corners.assign({fan[0][0], fan[0][1]});
        for (const TriangleCorners& triangle : fan) corners.push_back(triangle[2]);
        if (!triangulator.triangulate(corners, positions_, fan)) {
            return fail(ErrorCode::limit_exceeded,
                        concat("the face that starts at triangle ", first, " is concave with ",
                               count, " corners, the limit is ", max_concave_corners,
                               ": cut it in the program that made it"),
                        source_.name);
        }
        constexpr std::size_t large = 64;
        if ((count > large || polygon % large == 0) && is_cancelled(options_.execution.progress)) {
            return cancelled("reading", source_.name);
        }
    }
    polygons_ = {};
    return {};
}

Result<TriangleMesh> MeshAssembler::finish(Vertices vertices)
{
    if (auto status = cut_polygons(); !status) return tl::unexpected(status.error());
    if (vertices == Vertices::welded && welded_.size() == 0) {
        if (!fits_budget(weld_scratch_bytes(positions_.size()))) return tl::unexpected(error_);
        if (!weld_vertices(positions_, triangles_, options_.execution.progress)) {
            return cancelled("reading", source_.name);
        }
        positions_.shrink_to_fit();
    }
    auto mesh = make_triangle_mesh(std::move(positions_), std::move(triangles_));
    if (!mesh) mesh.error().where = source_.name;
    return mesh;
}

} // namespace proxima::detail
