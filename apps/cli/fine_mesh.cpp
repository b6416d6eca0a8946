#include "cli/fine_mesh.h"

#include "geometry/length.h"
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// How many pieces a side is cut into for pieces of this length.
std::uint32_t cuts_of(const Triangle& triangle, double length)
{
    constexpr double most_cuts = 64;
    double longest = 0;
    for (int side = 0; side < 3; ++side)
        longest = std::max(longest, length_of(triangle[(side + 1) % 3] - triangle[side]));
    const double cuts = std::ceil(longest / length);
    return static_cast<std::uint32_t>(cuts >= 1 ? std::min(cuts, most_cuts) : 1);
}

std::uint64_t pieces_of(const TriangleMesh& mesh, double length)
{
    std::uint64_t pieces = 0;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const std::uint64_t cuts = cuts_of(mesh.triangle(TriangleId{i}), length);
        pieces += cuts * cuts;
    }
    return pieces;
}

} // namespace

Result<TriangleMesh> finely_cut(const TriangleMesh& mesh, std::uint64_t most)
{
    double length = 0.01 * length_of(bounding_box(mesh).extent());
    while (length > 0 && std::isfinite(length) && pieces_of(mesh, length) > most &&
           pieces_of(mesh, length) > mesh.triangle_count())
        length *= 1.5;
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const std::uint32_t cuts = cuts_of(triangle, length);
        const auto first = static_cast<std::uint32_t>(positions.size());
        // Rows parallel to the side from corner 1 to corner 2, from corner 0 on.
        for (std::uint32_t row = 0; row <= cuts; ++row) {
            for (std::uint32_t column = 0; column <= row; ++column) {
                const double u = static_cast<double>(row - column) / cuts;
                const double v = static_cast<double>(column) / cuts;
                positions.emplace_back((1 - u - v) * triangle[0] + u * triangle[1] +
                                       v * triangle[2]);
            }
        }
        const auto at = [first](std::uint32_t row, std::uint32_t column) {
            return first + row * (row + 1) / 2 + column;
        };
        for (std::uint32_t row = 0; row < cuts; ++row) {
            for (std::uint32_t column = 0; column <= row; ++column) {
                triangles.push_back(
                    {at(row, column), at(row + 1, column), at(row + 1, column + 1)});
                if (column < row) {
                    triangles.push_back(
                        {at(row, column), at(row + 1, column + 1), at(row, column + 1)});
                }
            }
        }
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

} // namespace proxima
