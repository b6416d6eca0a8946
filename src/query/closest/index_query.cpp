#include "query/closest/index_query.h"

namespace proxima {

namespace {

template <class Scalar>
RowDistance first_vertex_of(std::span<const TriangleRow<Scalar>> rows)
{
    RowDistance first;
    for (std::uint32_t rank = 0; rank < rows.size(); ++rank) {
        for (const std::uint32_t vertex : rows[rank].vertices) {
            if (vertex >= first.feature) continue;
            first.feature = vertex;
            first.rank = rank;
        }
    }
    return first;
}

} // namespace

RowDistance first_vertex(std::span<const TriangleRow<float>> rows) noexcept
{
    return first_vertex_of(rows);
}

RowDistance first_vertex(std::span<const TriangleRow<double>> rows) noexcept
{
    return first_vertex_of(rows);
}

} // namespace proxima
