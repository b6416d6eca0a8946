#include "query/closest/describe_closest.h"

#include "index/index_parts.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

/// Where the lowest triangles of vertices and edges are.
struct FeatureIncidences {
    std::span<const std::uint32_t> vertices;
    std::span<const std::uint32_t> edges;
};

template <class Scalar>
ClosestFeature describe(const FeatureIncidences& incidences, const TriangleRow<Scalar>& row,
                        const RowScale& scale, const RowDistance& found)
{
    ClosestFeature answer;
    answer.feature = {found.kind(), found.id()};
    answer.squared_distance = scale.unscale_squared(found.squared);
    switch (found.kind()) {
    case FeatureKind::vertex: {
        const std::uint32_t incident = incidences.vertices[found.id()];
        answer.triangle = TriangleId{incidence::triangle(incident)};
        answer.barycentric[incidence::corner(incident)] = 1;
        answer.point = row.corner(static_cast<int>(corner_of(row, found.id())));
        break;
    }
    case FeatureKind::edge: {
        const std::uint32_t incident = incidences.edges[found.id()];
        answer.triangle = TriangleId{incidence::triangle(incident)};
        const std::size_t side = side_of(row, found.id());
        const double along = found.along[side];
        const auto next_to = [](std::size_t corner) { return corner == 2 ? 0 : corner + 1; };
        const auto lower_first = [&](bool backward, std::size_t from) {
            const std::size_t to = next_to(from);
            return backward ? std::array{to, from} : std::array{from, to};
        };
        const auto [lower, upper] = lower_first(row.backward(side), side);
        answer.point = (1 - along) * row.corner(static_cast<int>(lower)) +
                       along * row.corner(static_cast<int>(upper));
        const auto [first, second] =
            lower_first(incidence::backward(incident), incidence::corner(incident));
        answer.barycentric[first] = 1 - along;
        answer.barycentric[second] = along;
        break;
    }
    case FeatureKind::face: {
        answer.triangle = TriangleId{found.id()};
        const double all = found.parts[0] + found.parts[1] + found.parts[2];
        const double v = found.parts[2] / all;
        const double w = found.parts[0] / all;
        answer.barycentric = {std::max(0.0, 1 - v - w), v, w};
        answer.point =
            answer.barycentric[0] * row.corner(0) + v * row.corner(1) + w * row.corner(2);
        break;
    }
    }
    return answer;
}

} // namespace

ClosestFeature describe_closest(const IndexParts& index, const RowDistance& found) noexcept
{
    if (!found.found()) [[unlikely]]
        return no_closest_feature();
    const FeatureIncidences incidences{index.vertex_incidences(), index.edge_incidences()};
    const RowScale scale = row_scale_of(index);
    return index.double_rows().empty()
               ? describe(incidences, index.float_rows()[found.rank], scale, found)
               : describe(incidences, index.double_rows()[found.rank], scale, found);
}

TriangleId triangle_of(const IndexParts& index, const RowDistance& found) noexcept
{
    switch (found.kind()) {
    case FeatureKind::vertex:
        return TriangleId{incidence::triangle(index.vertex_incidences()[found.id()])};
    case FeatureKind::edge:
        return TriangleId{incidence::triangle(index.edge_incidences()[found.id()])};
    case FeatureKind::face:
        break;
    }
    return TriangleId{found.id()};
}

} // namespace proxima
