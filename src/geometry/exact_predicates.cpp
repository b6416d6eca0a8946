#include "geometry/exact_predicates.h"

#include "geometry/expansion.h"
#include "geometry/length.h"
#include "geometry/wide_integer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace proxima {
namespace {

using detail::WideInteger;

// Numbers of the exact stages: results of difference() and sum_difference(), and of +, - and * on
// these. sum_difference(p, a, b, s) is p - a - s b, of degree two. Wide integers hold it in units
// of 2^-2148, and differences in units of 2^-1074.
struct ByExpansions {
    static auto difference(double a, double b) noexcept { return detail::exact_difference(a, b); }
    static auto sum_difference(double p, double a, double b, double s) noexcept
    {
        return detail::exact_difference(p, a) + detail::exact_product(-s, b);
    }
};
struct ByWideIntegers {
    static auto difference(double a, double b) noexcept { return WideInteger(a) - WideInteger(b); }
    static auto sum_difference(double p, double a, double b, double s) noexcept
    {
        return difference(p, a) * WideInteger(1.0) - WideInteger(s) * WideInteger(b);
    }
};

bool fits(const Vec3& p) noexcept
{
    return detail::fits_expansion(p.x()) && detail::fits_expansion(p.y()) &&
           detail::fits_expansion(p.z());
}

bool fits_quartic(const Vec3& p) noexcept
{
    return detail::fits_quartic_expansion(p.x()) && detail::fits_quartic_expansion(p.y()) &&
           detail::fits_quartic_expansion(p.z());
}

bool fits_quartic(const Displacement& u) noexcept
{
    return fits_quartic(u.from) && fits_quartic(u.to);
}

bool fits_quartic(const SumDisplacement& w) noexcept
{
    return fits_quartic(w.point) && fits_quartic(w.a) && fits_quartic(w.b) &&
           detail::fits_quartic_expansion(w.scale);
}

/// An upper bound of |u x v| by component that ignores cancellation.
Vec3 cross_sizes(const Vec3& u, const Vec3& v) noexcept
{
    const Vec3 p = u.cwiseAbs();
    const Vec3 q = v.cwiseAbs();
    return {p.y() * q.z() + p.z() * q.y(), p.z() * q.x() + p.x() * q.z(),
            p.x() * q.y() + p.y() * q.x()};
}

bool fits(const Displacement& u) noexcept
{
    return fits(u.from) && fits(u.to);
}

/// Times a power of two, where doubles hold that.
Vec3 shifted(const Vec3& p, int exponent) noexcept
{
    return {std::scalbn(p.x(), exponent), std::scalbn(p.y(), exponent),
            std::scalbn(p.z(), exponent)};
}

template <class Exact>
auto component(const Displacement& u, int axis) noexcept
{
    return Exact::difference(u.to[axis], u.from[axis]);
}

template <class Exact>
auto component(const SumDisplacement& w, int axis) noexcept
{
    return Exact::sum_difference(w.point[axis], w.a[axis], w.b[axis], w.scale);
}

template <class Exact, class Last>
auto exact_determinant_of(const Displacement& u, const Displacement& v, const Last& w) noexcept
{
    const auto ux = component<Exact>(u, 0);
    const auto uy = component<Exact>(u, 1);
    const auto uz = component<Exact>(u, 2);
    const auto vx = component<Exact>(v, 0);
    const auto vy = component<Exact>(v, 1);
    const auto vz = component<Exact>(v, 2);
    const auto x = (uy * vz - uz * vy) * component<Exact>(w, 0);
    const auto y = (uz * vx - ux * vz) * component<Exact>(w, 1);
    const auto z = (ux * vy - uy * vx) * component<Exact>(w, 2);
    return x + y + z;
}

template <class Exact, class Last>
int exact_determinant_sign(const Displacement& u, const Displacement& v, const Last& w) noexcept
{
    return exact_determinant_of<Exact>(u, v, w).sign();
}

template <class Exact, class Last>
int exact_cross_component_sign(const Displacement& u, const Last& v, int axis) noexcept
{
    const int p = (axis + 1) % 3;
    const int q = (axis + 2) % 3;
    return (component<Exact>(u, p) * component<Exact>(v, q) -
            component<Exact>(u, q) * component<Exact>(v, p))
        .sign();
}

// Filter bounds. u = 2^-53. A computed difference is the true one times 1 + d, |d| <= u. A product
// of two differences carries three such factors, their difference a fourth: the error is at most
// ((1 + u)^4 - 1) S, S the sum of the true products' sizes, and the computed S is at least
// (1 - u)^4 of the true one: 4u + O(u^2) < 5u of the computed S. In three dimensions a term carries
// 4 + 1 (difference) + 1 (product) + 2 (sum) factors, S as many: 8u + O(u^2) < 9u.
// Where S is at least 2^-600 (and not infinite: then nothing compares as certain), what products
// lost by underflow, at most a few 2^-1074 times a size below 2^310, is within the slack of u S.
constexpr double unit_roundoff = 0x1p-53;
constexpr double safe_sum = 0x1p-600;
constexpr double safe_size = 0x1p+300;

} // namespace

int orient2d(const Vec2& a, const Vec2& b, const Vec2& c) noexcept
{
    const auto flat = [](const Vec2& p) noexcept { return Vec3(p.x(), p.y(), 0); };
    return cross_component_sign({flat(a), flat(b)}, Displacement{flat(a), flat(c)}, 2);
}

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept
{
    return determinant_sign({a, b}, {a, c}, Displacement{a, d});
}

int determinant_sign(const Displacement& u, const Displacement& v, const Displacement& w) noexcept
{
    const Vec3 p = u.rounded();
    const Vec3 q = v.rounded();
    const Vec3 r = w.rounded();
    const double yz = p.y() * q.z();
    const double zy = p.z() * q.y();
    const double zx = p.z() * q.x();
    const double xz = p.x() * q.z();
    const double xy = p.x() * q.y();
    const double yx = p.y() * q.x();
    const double value = (yz - zy) * r.x() + (zx - xz) * r.y() + (xy - yx) * r.z();
    const Vec3 reach = r.cwiseAbs();
    const double sizes = (std::abs(yz) + std::abs(zy)) * reach.x() +
                         (std::abs(zx) + std::abs(xz)) * reach.y() +
                         (std::abs(xy) + std::abs(yx)) * reach.z();
    const double error = 9 * unit_roundoff * sizes;
    if (sizes >= safe_sum && reach.maxCoeff() <= safe_size) {
        if (value - error > 0) return 1;
        if (value + error < 0) return -1;
    }
    if (fits(u) && fits(v) && fits(w)) return exact_determinant_sign<ByExpansions>(u, v, w);
    return exact_determinant_sign<ByWideIntegers>(u, v, w);
}

ScaledNumber exact_determinant(const Displacement& u, const Displacement& v,
                               const Displacement& w) noexcept
{
    ScaledNumber value;
    std::array<Displacement, 3> all = {u, v, w};
    for (Displacement& d : all) {
        if (fits(d)) continue;
        const int exponent =
            std::ilogb(std::max(d.from.cwiseAbs().maxCoeff(), d.to.cwiseAbs().maxCoeff()));
        const Displacement given = d;
        d = {shifted(given.from, -exponent), shifted(given.to, -exponent)};
        value.exponent += exponent;
        if (fits(d) && shifted(d.from, exponent) == given.from &&
            shifted(d.to, exponent) == given.to)
            continue;
        value = exact_determinant_of<ByWideIntegers>(u, v, w).rounded();
        value.exponent -= 3 * 1074;
        return value;
    }
    const auto exact = exact_determinant_of<ByExpansions>(all[0], all[1], all[2]);
    for (int i = 0; i < exact.size(); ++i) value.mantissa += exact[i];
    return value;
}

int cross_component_sign(const Displacement& u, const Displacement& v, int axis) noexcept
{
    const Vec3 a = u.rounded();
    const Vec3 b = v.rounded();
    const int p = (axis + 1) % 3;
    const int q = (axis + 2) % 3;
    const double left = a[p] * b[q];
    const double right = a[q] * b[p];
    const double value = left - right;
    const double sizes = std::abs(left) + std::abs(right);
    const double error = 5 * unit_roundoff * sizes;
    if (sizes >= safe_sum) {
        if (value - error > 0) return 1;
        if (value + error < 0) return -1;
    }
    if (fits(u) && fits(v)) return exact_cross_component_sign<ByExpansions>(u, v, axis);
    return exact_cross_component_sign<ByWideIntegers>(u, v, axis);
}

int determinant_sign(const Displacement& u, const Displacement& v,
                     const SumDisplacement& w) noexcept
{
    // One rounding more than in a difference, of terms that may cancel: bounded by their sizes.
    const Vec3 p = u.rounded();
    const Vec3 q = v.rounded();
    const Vec3 normal = p.cross(q);
    const Vec3 sizes = cross_sizes(p, q);
    const Vec3 reach = w.point.cwiseAbs() + w.a.cwiseAbs() + std::abs(w.scale) * w.b.cwiseAbs();
    const double value = normal.dot(w.rounded());
    const double size = sizes.dot(reach);
    // The last term bounds what scale * b loses by underflow.
    const double error = 16 * unit_roundoff * size + 0x1p-1070 * sizes.sum();
    if (size >= safe_sum && reach.maxCoeff() <= safe_size) {
        if (value - error > 0) return 1;
        if (value + error < 0) return -1;
    }
    if (fits_quartic(u) && fits_quartic(v) && fits_quartic(w))
        return exact_determinant_sign<ByExpansions>(u, v, w);
    return exact_determinant_sign<ByWideIntegers>(u, v, w);
}

int cross_component_sign(const Displacement& u, const SumDisplacement& w, int axis) noexcept
{
    if (fits_quartic(u) && fits_quartic(w))
        return exact_cross_component_sign<ByExpansions>(u, w, axis);
    return exact_cross_component_sign<ByWideIntegers>(u, w, axis);
}

Vec3 unit_normal(const Displacement& u, const Displacement& v) noexcept
{
    // Scaled by powers of two so that products do not overflow.
    const auto scaled = [](const Vec3& difference) noexcept {
        const double size = difference.cwiseAbs().maxCoeff();
        return shifted(difference, size > 0 ? -std::ilogb(size) : 0);
    };
    const Vec3 a = scaled(u.rounded());
    const Vec3 b = scaled(v.rounded());
    const Vec3 normal = a.cross(b);
    constexpr double safe_share = 1.0 / 16;  // not much is cancelled
    constexpr double safe_length = 0x1p-900; // no digits have vanished
    const double largest = normal.cwiseAbs().maxCoeff();
    if (largest >= safe_share * cross_sizes(a, b).maxCoeff() && largest > safe_length)
        return unit_of(normal);
    std::array<ScaledNumber, 3> parts;
    for (int axis = 0; axis < 3; ++axis) {
        parts[static_cast<std::size_t>(axis)] =
            exact_determinant(u, v, {Vec3::Zero(), Vec3::Unit(axis)});
    }
    const std::array<double, 3> exact = in_common_units(parts);
    return unit_of(Vec3(exact[0], exact[1], exact[2]));
}

bool are_parallel(const Displacement& u, const Displacement& v) noexcept
{
    for (int axis = 0; axis < 3; ++axis) {
        if (cross_component_sign(u, v, axis) != 0) return false;
    }
    return true;
}

bool point_same_way(const Displacement& u, const Displacement& v) noexcept
{
    const auto sign = [](const Displacement& d, int axis) {
        return static_cast<int>(d.to[axis] > d.from[axis]) -
               static_cast<int>(d.to[axis] < d.from[axis]);
    };
    for (int axis = 0; axis < 3; ++axis) {
        if (sign(u, axis) * sign(v, axis) < 0) return false;
    }
    return true;
}

bool is_degenerate(const Triangle& triangle) noexcept
{
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3;
        const int w = (axis + 2) % 3;
        const auto project = [&](int corner) noexcept {
            return Vec2(triangle[corner][u], triangle[corner][w]);
        };
        if (orient2d(project(0), project(1), project(2)) != 0) return false;
    }
    return true;
}

} // namespace proxima
