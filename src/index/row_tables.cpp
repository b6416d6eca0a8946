#include "index/row_tables.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace proxima {

namespace {

/// Whether a normal float holds the number exactly: by its bits, as compilers may drop the rounding
/// of a conversion there and back.
bool fits_float(double number)
{
    if (number == 0) return true;
    const auto bits = std::bit_cast<std::uint64_t>(number);
    constexpr std::uint64_t lost = (std::uint64_t{1} << 29U) - 1;
    const int exponent = std::ilogb(number);
    return (bits & lost) == 0 && exponent >= -126 && exponent <= 127;
}

/// Whether floats hold every position exactly.
bool fit_floats(const TriangleMesh& mesh)
{
    return std::ranges::all_of(mesh.positions(), [](const Vec3& p) {
        return fits_float(p[0]) && fits_float(p[1]) && fits_float(p[2]);
    });
}

/// Longest side by height beyond which a triangle's inside wants care: up to there feet are right
/// to 2^-52 times its square, of the side.
constexpr double thin_condition = 32;

template <class Scalar>
void fill_rows(const TriangleMesh& mesh, const Topology& topology,
               std::span<const TriangleId> order, GrowBuffer<TriangleRow<Scalar>>& rows)
{
    rows.resize(order.size());
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        const TriangleId id = order[rank];
        const Triangle triangle = mesh.triangle(id);
        TriangleRow<Scalar>& row = rows[rank];
        row = {};
        row.triangle = index(id) | (is_thin(triangle) ? TriangleRow<Scalar>::thin_bit : 0U);
        for (int i = 0; i < 3; ++i) {
            const auto k = static_cast<std::size_t>(i);
            for (int axis = 0; axis < 3; ++axis)
                row.coordinates[axis][i] = static_cast<Scalar>(triangle[i][axis]);
            const TriangleCorners& corners = mesh.triangles()[index(id)];
            row.vertices[i] = corners[k];
            if (corners[k] > corners[(k + 1) % 3])
                row.triangle |= TriangleRow<Scalar>::side_bit << k;
            row.edges[i] = index(topology.edges(id)[k]);
        }
    }
}

std::uint32_t place_of_vertex(const TriangleMesh& mesh, TriangleId triangle, std::uint32_t vertex)
{
    const TriangleCorners& corners = mesh.triangles()[index(triangle)];
    const auto corner = std::ranges::find(corners, vertex) - corners.begin();
    return place_word::make(index(triangle), static_cast<std::uint32_t>(corner), false);
}

/// The side between the first corners of its vertices, as side_of() has it.
std::uint32_t place_of_edge(const TriangleMesh& mesh, const Topology& topology, TriangleId triangle,
                            EdgeId edge)
{
    const TriangleCorners& corners = mesh.triangles()[index(triangle)];
    const auto first = [&](std::uint32_t corner) {
        return std::ranges::find(corners, corners[corner]) - corners.begin() == corner;
    };
    std::uint32_t side = 2;
    for (std::uint32_t k = 0; k < 2; ++k)
        if (topology.edges(triangle)[k] == edge && first(k) && first(k + 1)) side = k;
    const std::uint32_t next = side == 2 ? 0 : side + 1;
    return place_word::make(index(triangle), side, corners[side] > corners[next]);
}

} // namespace

bool is_thin(const Triangle& triangle) noexcept
{
    Vec3 ab = triangle[1] - triangle[0];
    Vec3 ac = triangle[2] - triangle[0];
    Vec3 bc = triangle[2] - triangle[1];
    const double size =
        std::max({ab.cwiseAbs().maxCoeff(), ac.cwiseAbs().maxCoeff(), bc.cwiseAbs().maxCoeff()});
    // Fourth powers of lengths outside of these leave the doubles.
    if (!(size > 0x1p-200 && size < 0x1p200) && size > 0 && std::isfinite(size)) {
        const int exponent = std::clamp(-std::ilogb(size), -1000, 1000);
        for (Vec3* const side : {&ab, &ac, &bc}) *side *= std::ldexp(1.0, exponent);
    }
    const double squared = std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
    return !(squared <= thin_condition * ab.cross(ac).norm());
}

std::uint64_t RowTables::bytes() const noexcept
{
    return float_rows.span().size_bytes() + double_rows.span().size_bytes() +
           vertex_places.span().size_bytes() + edge_places.span().size_bytes();
}

RowTables make_row_tables(const TriangleMesh& mesh, const Topology& topology,
                          std::span<const TriangleId> order)
{
    RowTables tables;
    if (fit_floats(mesh))
        fill_rows(mesh, topology, order, tables.float_rows);
    else
        fill_rows(mesh, topology, order, tables.double_rows);
    tables.vertex_places.resize(topology.vertex_count());
    for (std::uint32_t i = 0; i < topology.vertex_count(); ++i) {
        const auto star = topology.triangles(VertexId{i});
        tables.vertex_places[i] =
            star.empty() ? place_word::none : place_of_vertex(mesh, star.front(), i);
    }
    tables.edge_places.resize(topology.edge_count());
    for (std::uint32_t i = 0; i < topology.edge_count(); ++i) {
        const EdgeId edge{i};
        tables.edge_places[i] =
            place_of_edge(mesh, topology, topology.triangles(edge).front(), edge);
    }
    return tables;
}

} // namespace proxima
