#include "mesh/triangle_order.h"

#include "base/hilbert_code.h"
#include "base/morton_code.h"
#include "base/progress.h"

#include <algorithm>
#include <array>

namespace proxima {

std::optional<std::vector<KeyedIndex>> triangle_order(const TriangleMesh& mesh, const Box& bounds,
                                                      SpaceCurve curve, Progress* progress)
{
    constexpr unsigned key_bits = 3 * triangle_order_bits;
    StageSteps steps(progress, "sorting triangles",
                     (radix_passes(key_bits) + 1) * mesh.triangle_count());
    constexpr auto cells = static_cast<double>(1U << triangle_order_bits);
    const double edge = bounds.extent().maxCoeff();
    // Not infinite, for infinity times a mean of 0 is no number: an edge below 1e-302 is one cell.
    const double scale = std::min(cells / std::max(edge, 0x1p-1074), 0x1p1023);
    std::vector<KeyedIndex> items(mesh.triangle_count());
    for (std::size_t i = 0; i < items.size(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(i)});
        std::array<std::uint32_t, 3> at{};
        for (int axis = 0; axis < 3; ++axis) {
            const double low = bounds.lower[axis];
            const double mean = ((triangle[0][axis] - low) + (triangle[1][axis] - low) +
                                 (triangle[2][axis] - low)) /
                                3.0;
            at[static_cast<std::size_t>(axis)] =
                static_cast<std::uint32_t>(std::clamp(mean * scale, 0.0, cells - 1.0));
        }
        const std::uint64_t code =
            curve == SpaceCurve::morton ? morton_code(at) : hilbert_code(at, triangle_order_bits);
        items[i] = {code, static_cast<std::uint32_t>(i)};
        if (!steps.done(1)) return std::nullopt;
    }
    if (!radix_sort(items, key_bits, steps)) return std::nullopt;
    return items;
}

} // namespace proxima
