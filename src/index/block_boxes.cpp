#include "index/block_boxes.h"

#include "index/index_parts.h"
#include "index/row_tables.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace proxima {

namespace {

// How far boxes are drawn out, in units of the mesh's size and in steps of a node's grid. The
// kernel computes t of a plane as (32768 + q) (s r) + (g - o) r in floats, u = 2^-24: r = 1 / d is
// off by 2 u, s r by 1 u more, g - o and its product by 1 u each, the first product and the sum by
// 1 u each; |g| <= 32768 s + 1, |o| <= 1.01. Times |d| that is at most u (4 * 33023 s + 5 |plane -
// o| + |o|) < 0.008 s + 12 u. Where the ray's origin was moved to the root it is up to 1 u more,
// and where d was put away from zero less than 1 u (prepare_ray-inl.h).
constexpr double own_margin = 20 * 0x1p-24;
constexpr double step_margin = 1.0 / 64;

/// One axis of a node's grid.
struct GridAxis {
    float origin = 0;
    float step = 0;

    /// Takes in [lower, upper] with its margins by bytes 0 to 255: one step is left over on each
    /// side, of which the margins and the rounding of the origin take less than a tenth.
    static GridAxis around(double lower, double upper) noexcept
    {
        constexpr double steps = 253;
        GridAxis axis;
        axis.step = static_cast<float>((upper - lower + 2 * own_margin) / steps);
        const auto step = static_cast<double>(axis.step);
        axis.origin = static_cast<float>(lower - own_margin - step - 32768 * step);
        return axis;
    }
    [[nodiscard]] double plane(std::uint8_t byte) const noexcept
    {
        return static_cast<double>(origin) + (32768.0 + byte) * static_cast<double>(step);
    }
    [[nodiscard]] std::uint8_t below(double value) const noexcept
    {
        return to_byte(std::floor(steps_to(value - own_margin) - step_margin));
    }
    [[nodiscard]] std::uint8_t above(double value) const noexcept
    {
        return to_byte(std::ceil(steps_to(value + own_margin) + step_margin));
    }

private:
    [[nodiscard]] double steps_to(double value) const noexcept
    {
        const auto step_size = static_cast<double>(step);
        return (value - static_cast<double>(origin) - 32768 * step_size) / step_size;
    }
    static std::uint8_t to_byte(double steps) noexcept
    {
        return static_cast<std::uint8_t>(std::clamp(steps, 0.0, 255.0));
    }
};

/// The upper half of the least such float not below the value.
std::uint16_t upper_half(double value) noexcept
{
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    return static_cast<std::uint16_t>((bits >> 16U) + 1);
}

} // namespace

std::array<double, 8> write_boxes(IndexNode& node, const FloatBox& box,
                                  const std::array<const FloatBox*, 8>& children) noexcept
{
    std::array<double, 8> extents{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const GridAxis grid = GridAxis::around(static_cast<double>(box.lower[axis]),
                                               static_cast<double>(box.upper[axis]));
        node.origin[axis] = grid.origin;
        node.step[axis] = grid.step;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            std::uint8_t& lower = node.planes[axis][slot];
            std::uint8_t& upper = node.planes[axis][8 + slot];
            lower = 255;
            upper = 0;
            if (children[slot] == nullptr) continue;
            lower = grid.below(static_cast<double>(children[slot]->lower[axis]));
            upper = grid.above(static_cast<double>(children[slot]->upper[axis]));
            extents[slot] = std::max(extents[slot], grid.plane(upper) - grid.plane(lower));
        }
    }
    return extents;
}

double root_extent(const FloatBox& box) noexcept
{
    double extent = 2.1;
    for (std::size_t axis = 0; axis < 3; ++axis)
        extent = std::max(extent, double{box.upper[axis]} - double{box.lower[axis]});
    return extent;
}

void write_extent(IndexLeaf& leaf, double extent) noexcept
{
    leaf.extent_bits = upper_half(extent + 4 * own_margin);
}

bool write_vertex(IndexLeaf& leaf, std::size_t vertex, const Vec3& point,
                  const IndexFrame& frame) noexcept
{
    const Vec3 p = frame.to_frame(point);
    const double unscale = 1 / frame.scale;
    bool exact = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        leaf.coordinates[axis][vertex] = static_cast<float>(p[k]);
        exact = exact && is_float(p[k]) && p[k] * unscale + frame.center[k] == point[k];
    }
    return exact;
}

} // namespace proxima
