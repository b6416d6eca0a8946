// Where readers put what they find: vertices and faces in file order, within the memory budget.
#pragma once

#include "mesh/io/mesh_source.h"
#include "mesh/vertex_table.h"
#include "proxima/mesh_io.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima::detail {

/// Faces of more corners are refused.
inline constexpr std::size_t max_face_corners = std::size_t{1} << 20U;

/// Whether a finished mesh gets its equal vertices merged.
enum class Vertices : std::uint8_t { as_they_are, welded };

/// Collects a mesh. A false return means that error() says why. Polygons wait as fans and are cut
/// properly at the end, when all positions are known.
class MeshAssembler {
public:
    MeshAssembler(const MeshSource& source, const ReadOptions& options)
        : source_(source), options_(options)
    {}

    /// Reserves capacity for this many more than there are. Callers make sure that the file can hold them.
    [[nodiscard]] bool reserve_vertices(std::uint64_t count);
    [[nodiscard]] bool reserve_triangles(std::uint64_t count);

    [[nodiscard]] bool add_vertex(const Vec3& position)
    {
        if (positions_.size() == positions_.capacity() && !reserve_vertices(growth(positions_))) {
            return false;
        }
        positions_.push_back(position);
        return true;
    }

    [[nodiscard]] bool add_triangle(const TriangleCorners& corners)
    {
        if (triangles_.size() == triangles_.capacity() && !reserve_triangles(growth(triangles_))) {
            return false;
        }
        triangles_.push_back(corners);
        return true;
    }

    /// Adds a point or a segment, as a triangle without area. \pre 1 <= corners.size() <= 2
    [[nodiscard]] bool add_point_or_segment(std::span<const std::uint32_t> corners)
    {
        return add_triangle({corners.front(), corners.back(), corners.back()});
    }

    /// Makes a point of every vertex.
    [[nodiscard]] bool add_points_of_vertices();

    /// Whether points and lines are read, and not triangles alone.
    [[nodiscard]] bool takes_points_and_lines() const noexcept
    {
        return options_.primitives == Primitives::points_and_lines;
    }

    /// Adds the vertices of which there is no equal one yet (see weld_vertices), and tells the ids
    /// of all: for formats without indices, whose loose corners would be many times the vertices.
    /// Not to be mixed with add_vertex. \pre ids.size() == positions.size() <= weld_block
    static constexpr std::size_t weld_block = 192;
    /// Reserves capacity for so many more different vertices.
    [[nodiscard]] bool reserve_welded(std::size_t more);
    [[nodiscard]] bool add_welded(std::span<const Vec3> positions, std::span<std::uint32_t> ids);

    /// \pre 3 <= corners.size() <= max_face_corners
    [[nodiscard]] bool add_face(std::span<const std::uint32_t> corners)
    {
        if (corners.size() == 3) return add_triangle({corners[0], corners[1], corners[2]});
        return add_polygon(corners);
    }

    [[nodiscard]] std::size_t vertex_count() const noexcept { return positions_.size(); }
    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangles_.size(); }
    [[nodiscard]] const Error& error() const noexcept { return error_; }

    /// The mesh; this object is empty afterwards. \pre every index added is below vertex_count()
    [[nodiscard]] Result<TriangleMesh> finish(Vertices vertices);

private:
    // A face of more than three corners: first_triangle and the corner_count - 3 that follow.
    struct Polygon {
        std::uint32_t first_triangle = 0;
        std::uint32_t corner_count = 0;
    };

    template <class T>
    static std::uint64_t growth(const std::vector<T>& items) noexcept
    {
        constexpr std::uint64_t first_size = 1024;
        return items.empty() ? first_size : items.size();
    }

    [[nodiscard]] bool add_polygon(std::span<const std::uint32_t> corners);
    [[nodiscard]] bool fits_budget(std::uint64_t more_bytes);
    [[nodiscard]] Status cut_polygons();

    const MeshSource& source_;
    const ReadOptions& options_;
    std::vector<Vec3> positions_;
    std::vector<TriangleCorners> triangles_;
    std::vector<Polygon> polygons_;
    VertexTable welded_; ///< of positions_, by add_welded
    Error error_;
};

} // namespace proxima::detail
