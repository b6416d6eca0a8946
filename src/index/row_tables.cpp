#include "index/row_tables.h"

#include "base/parallel.h"
#include "index/index_parts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr std::uint64_t lost_by_floats = (std::uint64_t{1} << 29U) - 1; // bits that floats lack

/// Longest side by height beyond which a triangle's inside wants care: up to there feet are right
/// to 2^-52 times its square, of the side.
constexpr double thin_condition = 32;

constexpr std::size_t items_per_task = 4096;

/// edge_of(rank, id, side) is the number of an edge.
template <class Scalar, class EdgeOf>
void fill_rows(const TriangleMesh& mesh, const EdgeOf& edge_of, std::span<const TriangleId> order,
               double scale, Threads threads, GrowBuffer<TriangleRow<Scalar>>& rows)
{
    rows.resize(order.size());
    parallel_chunks(order.size(), items_per_task, threads, [&](std::size_t first, std::size_t end) {
        for (std::size_t rank = first; rank < end; ++rank) {
            const TriangleId id = order[rank];
            const Triangle triangle = mesh.triangle(id);
            const TriangleCorners& corners = mesh.triangles()[to_index(id)];
            TriangleRow<Scalar> row;
            row.triangle =
                to_index(id) | (is_thin(triangle, scale) ? TriangleRow<Scalar>::thin_bit : 0U);
            for (int i = 0; i < 3; ++i) {
                const auto k = static_cast<std::size_t>(i);
                for (int axis = 0; axis < 3; ++axis)
                    row.coordinates[axis][i] = static_cast<Scalar>(triangle[i][axis]);
                row.vertices[i] = corners[k];
                if (corners[k] > corners[(k + 1) % 3])
                    row.triangle |= TriangleRow<Scalar>::side_bit << k;
                row.edges[i] = edge_of(rank, id, k);
            }
            rows[rank] = row;
        }
    });
}

/// Rows of floats where they hold every position exactly.
template <class EdgeOf>
void fill_rows_of(const TriangleMesh& mesh, const EdgeOf& edge_of,
                  std::span<const TriangleId> order, double scale, Threads threads,
                  RowTables& tables)
{
    if (has_floats(mesh)) {
        fill_rows(mesh, edge_of, order, scale, threads, tables.float_rows);
    } else {
        fill_rows(mesh, edge_of, order, scale, threads, tables.double_rows);
    }
}

void copy_incidences(std::span<const std::uint32_t> from, GrowBuffer<std::uint32_t>& to)
{
    to.resize(from.size());
    std::ranges::copy(from, to.span().begin());
}

/// By vertex: its first corner in its lowest triangle.
void fill_vertex_incidences(const TriangleMesh& mesh, GrowBuffer<std::uint32_t>& incidences)
{
    incidences.resize(mesh.vertex_count());
    std::ranges::fill(incidences.span(), incidence::none);
    for (auto id = static_cast<std::uint32_t>(mesh.triangle_count()); id-- > 0;) {
        for (std::uint32_t corner = 3; corner-- > 0;)
            incidences[mesh.triangles()[id][corner]] = incidence::make(id, corner, false);
    }
}

/// Where an edge is in its lowest triangle: the side between the first corners of its
/// vertices, as side_of() has it. They are two where two corners are one vertex.
std::uint32_t incidence_of_edge(const TriangleMesh& mesh, const EdgeNumbers& edges,
                                std::uint32_t edge)
{
    const std::uint32_t triangle = edges.first_sides[edge] / 3;
    const TriangleCorners& corners = mesh.triangles()[triangle];
    const auto is_first = [&](std::uint32_t corner) {
        return std::ranges::find(corners, corners[corner]) - corners.begin() == corner;
    };
    std::uint32_t side = 2;
    for (std::uint32_t k = 0; k < 2; ++k) {
        if (edges.triangle_edges[triangle][k] == EdgeId{edge} && is_first(k) && is_first(k + 1))
            side = k;
    }
    const std::uint32_t next = side == 2 ? 0 : side + 1;
    return incidence::make(triangle, side, corners[side] > corners[next]);
}

} // namespace

bool is_thin(const Triangle& triangle, double scale) noexcept
{
    Vec3 ab = triangle[1] - triangle[0];
    Vec3 ac = triangle[2] - triangle[0];
    Vec3 bc = triangle[2] - triangle[1];
    const double size =
        std::max({ab.cwiseAbs().maxCoeff(), ac.cwiseAbs().maxCoeff(), bc.cwiseAbs().maxCoeff()});
    if (size > 0 && size * scale < least_side) return true;
    const auto longest = [&] {
        return std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
    };
    double squared = longest();
    // Fourth powers of lengths outside of these leave the doubles.
    if (!(squared > 0x1p-400 && squared < 0x1p400)) {
        if (size > 0 && std::isfinite(size)) {
            const double unit = std::ldexp(1.0, std::clamp(-std::ilogb(size), -1000, 1000));
            for (Vec3* const side : {&ab, &ac, &bc}) *side *= unit;
            squared = longest();
        }
    }
    return !(squared <= thin_condition * ab.cross(ac).norm());
}

// By its bits: g++ 12 drops the rounding of a conversion there and back where it makes vectors of
// it.
bool is_float(double value) noexcept
{
    const double size = std::abs(value);
    return size == 0 || ((std::bit_cast<std::uint64_t>(value) & lost_by_floats) == 0 &&
                         size >= static_cast<double>(std::numeric_limits<float>::min()) &&
                         size <= static_cast<double>(std::numeric_limits<float>::max()));
}

bool has_floats(const TriangleMesh& mesh) noexcept
{
    return std::ranges::all_of(mesh.positions(), [](const Vec3& p) {
        return is_float(p.x()) && is_float(p.y()) && is_float(p.z());
    });
}

std::uint64_t RowTables::bytes() const noexcept
{
    return float_rows.span().size_bytes() + double_rows.span().size_bytes() +
           vertex_incidences.span().size_bytes() + edge_incidences.span().size_bytes();
}

RowTables make_row_tables(const TriangleMesh& mesh, const EdgeNumbers& edges,
                          std::span<const TriangleId> order, double scale, Threads threads)
{
    RowTables tables;
    const auto edge_of = [&](std::size_t /*rank*/, TriangleId id, std::size_t side) {
        return to_index(edges.triangle_edges[to_index(id)][side]);
    };
    fill_rows_of(mesh, edge_of, order, scale, threads, tables);
    fill_vertex_incidences(mesh, tables.vertex_incidences);
    tables.edge_incidences.resize(edges.first_sides.size());
    parallel_chunks(edges.first_sides.size(), items_per_task, threads,
                    [&](std::size_t first, std::size_t end) {
                        for (auto edge = static_cast<std::uint32_t>(first); edge < end; ++edge)
                            tables.edge_incidences[edge] = incidence_of_edge(mesh, edges, edge);
                    });
    return tables;
}

RowTables move_row_tables(const TriangleMesh& mesh, const IndexArrays& old, double scale,
                          Threads threads)
{
    RowTables tables;
    if (old.double_rows.empty()) {
        const auto edge_of = [&](std::size_t rank, TriangleId /*id*/, std::size_t side) {
            return old.float_rows[rank].edges[side];
        };
        fill_rows_of(mesh, edge_of, old.ids, scale, threads, tables);
    } else {
        const auto edge_of = [&](std::size_t rank, TriangleId /*id*/, std::size_t side) {
            return old.double_rows[rank].edges[side];
        };
        fill_rows_of(mesh, edge_of, old.ids, scale, threads, tables);
    }
    copy_incidences(old.vertex_incidences, tables.vertex_incidences);
    copy_incidences(old.edge_incidences, tables.edge_incidences);
    return tables;
}

} // namespace proxima
