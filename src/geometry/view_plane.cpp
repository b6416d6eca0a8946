#include "geometry/view_plane.h"

#include "geometry/exact_predicates.h"
#include "geometry/expansion.h"
#include "geometry/whole_numbers.h"

#include <limits>

namespace proxima {

namespace {

using detail::WideInteger;

// More than underflow takes from the few products of a filter.
constexpr double plane_underflow = 16 * std::numeric_limits<double>::min();

bool fits(const ViewPlane& plane, const Vec3& point) noexcept
{
    bool all = detail::fits_expansion(plane.offset);
    for (int k = 0; k < 3; ++k)
        all = all && detail::fits_expansion(plane.normal[k]) && detail::fits_expansion(point[k]);
    return all;
}

using PlaneRow = std::array<double, 4>;

PlaneRow row(const ViewPlane& plane) noexcept
{
    return {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset};
}

/// The row times the power of two that brings its largest number to between a half and one (numbers
/// below 2^-1000 less far), so that in products with other rows nothing overflows, and nothing that
/// matters underflows.
PlaneRow scaled(const PlaneRow& numbers) noexcept
{
    double largest = 0;
    for (const double number : numbers) largest = std::max(largest, std::abs(number));
    int exponent = 0;
    std::frexp(largest, &exponent);
    const double scale = std::ldexp(1.0, std::min(-exponent, 1000));
    return {scale * numbers[0], scale * numbers[1], scale * numbers[2], scale * numbers[3]};
}

int exact_side(const ViewPlane& plane, const Vec3& point) noexcept
{
    if (fits(plane, point)) {
        detail::Expansion<2> offset;
        offset.append(plane.offset);
        const auto product = [&](int k) {
            return detail::exact_product(plane.normal[k], point[k]);
        };
        return ((product(0) + product(1)) + (product(2) + offset)).sign();
    }
    const auto p = detail::whole_numbers(row(plane));
    const auto x = detail::whole_numbers(point);
    return (p[0] * x[0] + p[1] * x[1] + (p[2] * x[2] + p[3] * x[3])).sign();
}

/// The determinant of four rows, by minors of the first two and of the last two.
template <class Number, class Row>
Number determinant(const Row& a, const Row& b, const Row& c, const Row& d)
{
    const auto minors = [](const Row& p, const Row& q) {
        const auto minor = [&](std::size_t i, std::size_t j) -> Number {
            return p[i] * q[j] - p[j] * q[i];
        };
        return std::array<Number, 6>{minor(0, 1), minor(0, 2), minor(0, 3),
                                     minor(2, 3), minor(1, 3), minor(1, 2)};
    };
    const auto s = minors(a, b);
    const auto t = minors(c, d);
    return (s[0] * t[3] - s[1] * t[4] + s[2] * t[5]) + (s[3] * t[0] - s[4] * t[1] + s[5] * t[2]);
}

} // namespace

int side_of_plane(const ViewPlane& plane, const Vec3& point) noexcept
{
    // Each product and each of three sums is off by u = 2^-53 of what it has: 4 u of the sizes.
    const double x = plane.normal.x() * point.x();
    const double y = plane.normal.y() * point.y();
    const double z = plane.normal.z() * point.z();
    const double value = ((x + y) + z) + plane.offset;
    const double size = ((std::abs(x) + std::abs(y)) + std::abs(z)) + std::abs(plane.offset);
    const double error = 0x1p-50 * size + plane_underflow;
    if (value > error) return 1;
    if (value < -error) return -1;
    return exact_side(plane, point);
}

int side_of_plane(const ViewPlane& plane, const PlaneMeeting& point) noexcept
{
    // By Cramer's rule the point is in the cofactors of the last row, the last of which is the
    // determinant of the normals.
    const auto from_zero = [](const Vec3& to) { return Displacement{Vec3::Zero(), to}; };
    const int weight = determinant_sign(from_zero(point[0].normal), from_zero(point[1].normal),
                                        from_zero(point[2].normal));
    const std::array<PlaneRow, 4> rows = {row(point[0]), row(point[1]), row(point[2]), row(plane)};
    // Each of 24 products of four is at most 1 and has at most 3 + 3 + 3 roundings: the bound is far
    // above them, and above what underflows.
    const auto value =
        determinant<double>(scaled(rows[0]), scaled(rows[1]), scaled(rows[2]), scaled(rows[3]));
    constexpr double error = 24 * 0x1p-48;
    if (value > error) return weight;
    if (value < -error) return -weight;
    const auto exact =
        determinant<WideInteger>(detail::whole_numbers(rows[0]), detail::whole_numbers(rows[1]),
                                 detail::whole_numbers(rows[2]), detail::whole_numbers(rows[3]));
    return exact.sign() * weight;
}

} // namespace proxima
