#include "morton_order.h"

#include <algorithm>
#include <utility>

namespace proxima::bench {
namespace {

constexpr double cells_per_axis = 1 << 20;

/// Moves bit i of 20 to bit 3 i.
std::uint64_t spread(std::uint64_t bits)
{
    bits = (bits | bits << 32U) & 0x001F00000000FFFFU;
    bits = (bits | bits << 16U) & 0x001F0000FF0000FFU;
    bits = (bits | bits << 8U) & 0x100F00F00F00F00FU;
    bits = (bits | bits << 4U) & 0x10C30C30C30C30C3U;
    return (bits | bits << 2U) & 0x1249249249249249U;
}

} // namespace

std::vector<std::uint32_t> morton_order(std::span<const Vec3> points, const Box& box)
{
    const double edge = std::max(box.extent().maxCoeff(), 1e-300);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> codes(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3 place = cells_per_axis / edge * (points[i] - box.lower);
        std::uint64_t code = 0;
        for (int k = 0; k < 3; ++k) {
            const double cell = std::clamp(place[k], 0.0, cells_per_axis - 1);
            code |= spread(static_cast<std::uint64_t>(cell)) << static_cast<unsigned>(k);
        }
        codes[i] = {code, static_cast<std::uint32_t>(i)};
    }
    std::ranges::sort(codes);
    std::vector<std::uint32_t> order(points.size());
    std::ranges::transform(codes, order.begin(), [](const auto& code) { return code.second; });
    return order;
}

} // namespace proxima::bench
