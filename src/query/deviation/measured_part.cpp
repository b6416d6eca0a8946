#include "query/deviation/measured_part.h"

#include <algorithm>
#include <cmath>

namespace proxima {

std::size_t longest_side_of(const std::array<Vec3, 3>& corners) noexcept
{
    std::size_t longest = 0;
    double most = -1;
    for (std::size_t i = 0; i < 3; ++i) {
        const double squared = (corners[next_corner(i)] - corners[i]).squaredNorm();
        if (!(squared > most)) continue;
        most = squared;
        longest = i;
    }
    return longest;
}

double MeasuredPart::reach(const Vec3& p) const noexcept
{
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i)
        least = std::min(least, nearest[i].distance + (p - corners[i]).norm());
    return least;
}

MeasuredPart::Halves MeasuredPart::halves(const SurfacePair& pair) const noexcept
{
    const std::size_t from = longest_side_of(corners);
    const std::size_t to = next_corner(from);
    Halves result{.parts = {*this, *this},
                  .corner = corners[from] + 0.5 * (corners[to] - corners[from]),
                  .nearest = {}};
    result.nearest = pair.nearest(result.corner, reach(result.corner));
    for (std::size_t i = 0; i < 2; ++i) {
        const std::size_t corner = i == 0 ? to : from;
        result.parts[i].corners[corner] = result.corner;
        result.parts[i].nearest[corner] = result.nearest;
        result.parts[i].weight = 0.5 * weight;
        result.parts[i].cuts = cuts + 1;
    }
    return result;
}

double upper_by(const SurfacePair& pair, const MeasuredPart& part, std::uint32_t row) noexcept
{
    double most = 0;
    for (const Vec3& corner : part.corners) most = std::max(most, pair.distance(corner, row));
    return most;
}

BoundedPart bounded_part(const SurfacePair& pair, const MeasuredPart& part,
                         std::uint32_t row_a) noexcept
{
    BoundedPart result{.part = part, .row_a = row_a, .upper = HUGE_VAL};
    for (const NearestRow& nearest : part.nearest)
        result.upper = std::min(result.upper, upper_by(pair, part, nearest.row));
    return result;
}

BoundedPart bounded_triangle(const SurfacePair& pair, const MeasuredVertices& vertices,
                             std::uint32_t row_a) noexcept
{
    return bounded_part(
        pair,
        {.corners = pair.a().triangle(row_a).vertices, .nearest = vertices.of_row(pair.a(), row_a)},
        row_a);
}

bool is_row_of_b(const SurfacePair& pair, const std::array<Vec3, 3>& corners,
                 std::uint32_t row) noexcept
{
    if (!pair.is_exact()) return false;
    const Triangle other = pair.b().triangle(row);
    return std::ranges::all_of(corners, [&](const Vec3& corner) {
        return std::ranges::find(other.vertices, corner) != other.vertices.end();
    });
}

} // namespace proxima
