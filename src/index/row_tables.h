// What queries read of the mesh itself: a row per triangle, and where vertices and edges are.
#pragma once

#include "base/grow_buffer.h"
#include "index/triangle_row.h"
#include "mesh/edge_numbers.h"
#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>

namespace proxima {

struct IndexArrays;

struct RowTables {
    GrowBuffer<TriangleRow<float>> float_rows; ///< one of the two is empty
    GrowBuffer<TriangleRow<double>> double_rows;
    GrowBuffer<std::uint32_t> vertex_incidences; ///< incidence
    GrowBuffer<std::uint32_t> edge_incidences;

    [[nodiscard]] std::uint64_t bytes() const noexcept;
};

/// Sides of triangles below this, times a mesh's scale, have fourth powers that leave the doubles.
inline constexpr double least_side = 0x1p-150;

/// Whether rows call it thin: less than 1/32 as high as its longest side is long, or its sides are
/// below least_side. \param scale brings the mesh's size to about 1
[[nodiscard]] bool is_thin(const Triangle& triangle, double scale) noexcept;

/// Whether a float, not a subnormal one, holds the same number.
[[nodiscard]] bool is_float(double value) noexcept;

/// Whether floats hold every position exactly. O(vertices).
[[nodiscard]] bool has_floats(const TriangleMesh& mesh) noexcept;

/// Rows in the given order, of floats where they hold every position exactly. O(mesh); the same for
/// any number of threads. `scale` is that of the index.
[[nodiscard]] RowTables make_row_tables(const TriangleMesh& mesh, const EdgeNumbers& edges,
                                        std::span<const TriangleId> order, double scale,
                                        Threads threads);

/// Those of an index whose vertices moved: edges and incidences, which triangles alone decide, are its own.
/// \pre the mesh has the triangles of the index
[[nodiscard]] RowTables move_row_tables(const TriangleMesh& mesh, const IndexArrays& old,
                                        double scale, Threads threads);

} // namespace proxima
