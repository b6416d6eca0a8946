#include "thesis/octree_generation/rounding_bounds.h"

#include <cmath>

namespace proxima {
namespace {

// Within these, products of three edges and a length neither overflow nor lose bits that matter to
// underflow: (2^-240)^3 2^-140 u is far above 2^-1022, (2^240)^4 and its sums far below 2^1023.
constexpr int smallest_edge_exponent = -240;
constexpr int smallest_half_size_exponent = -140;
constexpr int largest_exponent = 240;

[[nodiscard]] bool all_below(const Vec3& lengths, int exponent) noexcept
{
    return (lengths.array() < std::ldexp(1.0, exponent)).all();
}

[[nodiscard]] bool is_edge_in_range(const Vec3& edge) noexcept
{
    const auto in_range = [](double length) {
        return length == 0 || std::abs(length) >= std::ldexp(1.0, smallest_edge_exponent);
    };
    return in_range(edge.x()) && in_range(edge.y()) && in_range(edge.z());
}

} // namespace

RoundingBoundsMaker::RoundingBoundsMaker(const Triangle& triangle) noexcept
    : box_(bounding_box(triangle)), in_range_(is_edge_in_range(triangle[1] - triangle[0]) &&
                                              is_edge_in_range(triangle[2] - triangle[1]) &&
                                              is_edge_in_range(triangle[0] - triangle[2]))
{}

RoundingBounds RoundingBoundsMaker::next(const Vec3& half_size) noexcept
{
    if (!root_edge_) root_edge_ = 4 * half_size;

    RoundingBounds bounds;
    Box& near = bounds.centres.near;
    near = {box_.lower - 4 * half_size, box_.upper + 4 * half_size};
    bounds.spread = box_.extent() + 4 * half_size;
    bounds.reach = near.lower.cwiseAbs().cwiseMax(near.upper.cwiseAbs()) + half_size;
    bounds.slack = 8 * unit_roundoff * (*root_edge_ + bounds.reach);
    const bool resolved = (half_size.array() > bounds.slack.array()).all();
    const bool half_size_in_range =
        (half_size.array() >= std::ldexp(1.0, smallest_half_size_exponent)).all();
    bounds.centres.bounded = in_range_ && resolved && half_size_in_range &&
                             all_below(bounds.reach, largest_exponent) &&
                             all_below(*root_edge_, largest_exponent);
    return bounds;
}

} // namespace proxima
