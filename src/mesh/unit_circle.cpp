#include "mesh/unit_circle.h"

#include "base/check.h"

#include <cmath>

namespace proxima {

namespace {

__extension__ using Wide = unsigned __int128;

constexpr unsigned fraction_bits = 60;
constexpr std::uint64_t one = std::uint64_t{1} << fraction_bits;
constexpr std::uint64_t quarter_pi = 905502432259640355; // pi / 4 in units of 2^-60

std::uint64_t multiply(std::uint64_t a, std::uint64_t b) noexcept
{
    return static_cast<std::uint64_t>(static_cast<Wide>(a) * b >> fraction_bits);
}

double rounded(std::uint64_t fixed) noexcept
{
    constexpr unsigned dropped_bits = fraction_bits - 40;
    const std::uint64_t half = std::uint64_t{1} << (dropped_bits - 1);
    return std::ldexp(static_cast<double>((fixed + half) >> dropped_bits), -40);
}

// Taylor series of the angle part / count * 45 degrees; the terms after x^19 are below 2^-60.
CirclePoint first_octant(std::uint64_t part, std::uint64_t count) noexcept
{
    const auto angle = static_cast<std::uint64_t>(static_cast<Wide>(quarter_pi) * part / count);
    const std::uint64_t square = multiply(angle, angle);
    std::uint64_t cosine_term = one;
    std::uint64_t sine_term = angle;
    std::uint64_t cosine = one;
    std::uint64_t sine = angle;
    for (std::uint64_t power = 2; power <= 18; power += 2) {
        cosine_term = multiply(cosine_term, square) / (power * (power - 1));
        sine_term = multiply(sine_term, square) / (power * (power + 1));
        const bool subtract = power % 4 == 2;
        cosine = subtract ? cosine - cosine_term : cosine + cosine_term;
        sine = subtract ? sine - sine_term : sine + sine_term;
    }
    return {rounded(cosine), rounded(sine)};
}

} // namespace

CirclePoint unit_circle(std::uint32_t step, std::uint32_t count) noexcept
{
    PROXIMA_CHECK_GT(count, 0U);
    const std::uint64_t eighths = std::uint64_t{8} * (step % count);
    const std::uint64_t octant = eighths / count;
    const std::uint64_t rest = eighths % count;
    // Every odd octant is the mirror image of the one before it.
    const auto [c, s] = first_octant(octant % 2 == 0 ? rest : count - rest, count);
    switch (octant) {
    case 0:
        return {c, s};
    case 1:
        return {s, c};
    case 2:
        return {0.0 - s, c};
    case 3:
        return {0.0 - c, s};
    case 4:
        return {0.0 - c, 0.0 - s};
    case 5:
        return {0.0 - s, 0.0 - c};
    case 6:
        return {s, 0.0 - c};
    default:
        return {c, 0.0 - s};
    }
}

double on_circle_grid(double value) noexcept
{
    // Adding 1.5 * 2^12 leaves 40 bits behind the point.
    constexpr double shift = 1.5 * (1 << 12);
    return (value + shift) - shift;
}

} // namespace proxima
