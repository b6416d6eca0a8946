#include "proxima/geometry/exact_predicates.h"

#include "proxima/geometry/expansion.h"
#include "proxima/geometry/wide_integer.h"

#include <cmath>

namespace proxima {
namespace {

using detail::WideInteger;

// Numbers of the exact stages: what difference() makes, and what +, - and * make of it.
struct ByExpansions {
    static auto difference(double a, double b) noexcept { return detail::exact_difference(a, b); }
};
struct ByWideIntegers {
    static auto difference(double a, double b) noexcept { return WideInteger(a) - WideInteger(b); }
};

bool fits(const Vec2& p) noexcept
{
    return detail::fits_expansion(p.x()) && detail::fits_expansion(p.y());
}

bool fits(const Vec3& p) noexcept
{
    return detail::fits_expansion(p.x()) && detail::fits_expansion(p.y()) &&
           detail::fits_expansion(p.z());
}

template <class Exact>
int orient2d_sign(const Vec2& a, const Vec2& b, const Vec2& c) noexcept
{
    const auto left = Exact::difference(b.x(), a.x()) * Exact::difference(c.y(), a.y());
    const auto right = Exact::difference(b.y(), a.y()) * Exact::difference(c.x(), a.x());
    return (left - right).sign();
}

template <class Exact>
int orient3d_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept
{
    const auto bx = Exact::difference(b.x(), a.x());
    const auto by = Exact::difference(b.y(), a.y());
    const auto bz = Exact::difference(b.z(), a.z());
    const auto cx = Exact::difference(c.x(), a.x());
    const auto cy = Exact::difference(c.y(), a.y());
    const auto cz = Exact::difference(c.z(), a.z());
    const auto x = (by * cz - bz * cy) * Exact::difference(d.x(), a.x());
    const auto y = (bz * cx - bx * cz) * Exact::difference(d.y(), a.y());
    const auto z = (bx * cy - by * cx) * Exact::difference(d.z(), a.z());
    return (x + y + z).sign();
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
    const double left = (b.x() - a.x()) * (c.y() - a.y());
    const double right = (b.y() - a.y()) * (c.x() - a.x());
    const double value = left - right;
    const double sizes = std::abs(left) + std::abs(right);
    const double error = 5 * unit_roundoff * sizes;
    if (sizes >= safe_sum) {
        if (value - error > 0) return 1;
        if (value + error < 0) return -1;
    }
    if (fits(a) && fits(b) && fits(c)) return orient2d_sign<ByExpansions>(a, b, c);
    return orient2d_sign<ByWideIntegers>(a, b, c);
}

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept
{
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const Vec3 ad = d - a;
    const double yz = ab.y() * ac.z();
    const double zy = ab.z() * ac.y();
    const double zx = ab.z() * ac.x();
    const double xz = ab.x() * ac.z();
    const double xy = ab.x() * ac.y();
    const double yx = ab.y() * ac.x();
    const double value = (yz - zy) * ad.x() + (zx - xz) * ad.y() + (xy - yx) * ad.z();
    const Vec3 reach = ad.cwiseAbs();
    const double sizes = (std::abs(yz) + std::abs(zy)) * reach.x() +
                         (std::abs(zx) + std::abs(xz)) * reach.y() +
                         (std::abs(xy) + std::abs(yx)) * reach.z();
    const double error = 9 * unit_roundoff * sizes;
    if (sizes >= safe_sum && reach.maxCoeff() <= safe_size) {
        if (value - error > 0) return 1;
        if (value + error < 0) return -1;
    }
    if (fits(a) && fits(b) && fits(c) && fits(d)) return orient3d_sign<ByExpansions>(a, b, c, d);
    return orient3d_sign<ByWideIntegers>(a, b, c, d);
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
