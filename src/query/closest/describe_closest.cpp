#include "query/closest/describe_closest.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

template <class Scalar>
ClosestFeature describe(const ProximityArrays& arrays, std::span<const TriangleRow<Scalar>> rows,
                        const RowDistance& found)
{
    const TriangleRow<Scalar>& row = rows[found.rank];
    ClosestFeature answer;
    answer.feature = {found.kind(), found.id()};
    answer.squared_distance = found.squared;
    switch (found.kind()) {
    case FeatureKind::vertex: {
        const std::uint32_t place = arrays.vertex_places[found.id()];
        answer.triangle = TriangleId{place_word::triangle(place)};
        answer.barycentric[place_word::corner(place)] = 1;
        answer.point = row.corner(static_cast<int>(corner_of(row, found.id())));
        break;
    }
    case FeatureKind::edge: {
        const std::uint32_t place = arrays.edge_places[found.id()];
        answer.triangle = TriangleId{place_word::triangle(place)};
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
            lower_first(place_word::backward(place), place_word::corner(place));
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

ClosestFeature describe_closest(const ProximityOctree& octree, const RowDistance& found) noexcept
{
    if (!found.found()) [[unlikely]]
        return no_closest_feature();
    const ProximityArrays& arrays = octree.arrays();
    return arrays.double_rows.empty() ? describe(arrays, arrays.float_rows, found)
                                      : describe(arrays, arrays.double_rows, found);
}

} // namespace proxima
