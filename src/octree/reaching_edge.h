// The size of a root that holds a mesh although doubles round.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

namespace proxima {

/// The smallest double edge, at least `edge`, whose end lower + edge reaches `upper`. \pre edge > 0
[[nodiscard]] inline double reaching_edge(double lower, double edge, double upper) noexcept
{
    if (!(lower + edge < upper)) return edge;
    // By bisection of the bits, whose order is that of positive doubles. Far from the origin the
    // edge's next doubles are so much closer than the end's that steps would take forever.
    auto below = std::bit_cast<std::uint64_t>(edge);
    auto reaching = std::bit_cast<std::uint64_t>(std::numeric_limits<double>::infinity());
    while (reaching - below > 1) {
        const std::uint64_t middle = below + (reaching - below) / 2;
        (lower + std::bit_cast<double>(middle) < upper ? below : reaching) = middle;
    }
    return std::bit_cast<double>(reaching);
}

} // namespace proxima
