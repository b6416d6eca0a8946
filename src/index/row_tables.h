// What queries read of the mesh itself: a row per triangle, and where vertices and edges are.
#pragma once

#include "base/grow_buffer.h"
#include "geometry/shapes.h"
#include "index/triangle_row.h"
#include "mesh/topology.h"
#include "mesh/triangle_mesh.h"

#include <cstdint>
#include <span>

namespace proxima {

struct RowTables {
    GrowBuffer<TriangleRow<float>> float_rows; ///< one of the two is empty
    GrowBuffer<TriangleRow<double>> double_rows;
    GrowBuffer<std::uint32_t> vertex_places; ///< place_word
    GrowBuffer<std::uint32_t> edge_places;

    [[nodiscard]] std::uint64_t bytes() const noexcept;
};

/// Whether rows call it thin: less than 1/32 as high as its longest side is long.
[[nodiscard]] bool is_thin(const Triangle& triangle) noexcept;

/// Rows in the given order, of floats where they hold every position exactly. O(mesh).
[[nodiscard]] RowTables make_row_tables(const TriangleMesh& mesh, const Topology& topology,
                                        std::span<const TriangleId> order);

} // namespace proxima
