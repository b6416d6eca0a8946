#include "geometry/ray_triangle.h"

#include "oracles/integer_overlap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace proxima::ray_triangle_test {
namespace {

using oracle::cross;
using oracle::dot;
using oracle::IntegerTriangle;
using oracle::Point;
using oracle::subtract;
using oracle::Wide;

struct Fraction {
    Wide numerator = 0;
    Wide denominator = 1; ///< positive
    friend bool operator<(const Fraction& a, const Fraction& b)
    {
        return a.numerator * b.denominator < b.numerator * a.denominator;
    }
    [[nodiscard]] double value() const
    {
        return static_cast<double>(numerator) / static_cast<double>(denominator);
    }
};

Fraction fraction(Wide numerator, Wide denominator)
{
    return denominator < 0 ? Fraction{-numerator, -denominator} : Fraction{numerator, denominator};
}

/// The line's stretch of t within a set.
struct Stretch {
    Fraction first;
    Fraction last;
};

void join(std::optional<Stretch>& all, const std::optional<Stretch>& one)
{
    if (!one) return;
    if (!all) {
        all = one;
        return;
    }
    if (one->first < all->first) all->first = one->first;
    if (all->last < one->last) all->last = one->last;
}

/// Where the line o + t d meets the segment from a to b, or the point a = b.
std::optional<Stretch> meet_segment(const Point& o, const Point& d, const Point& a, const Point& b)
{
    const Point e = subtract(b, a);
    const Point from = subtract(a, o);
    const Point n = cross(d, e);
    if (dot(n, n) == 0) { // along the line, or a point
        const Point off = cross(d, from);
        if (dot(off, off) != 0) return std::nullopt;
        const Fraction at_a = fraction(dot(from, d), dot(d, d));
        const Fraction at_b = fraction(dot(subtract(b, o), d), dot(d, d));
        return at_a < at_b ? Stretch{at_a, at_b} : Stretch{at_b, at_a};
    }
    if (dot(from, n) != 0) return std::nullopt;
    const Wide along = dot(cross(from, d), n);
    if (along < 0 || along > dot(n, n)) return std::nullopt;
    const Fraction t = fraction(dot(cross(from, e), n), dot(n, n));
    return Stretch{t, t};
}

/// By the plane and three half-planes; segments where there is no plane.
std::optional<Stretch> meet_triangle(const Point& o, const Point& d,
                                     const IntegerTriangle& triangle)
{
    const auto& v = triangle.vertices;
    const Point n = cross(subtract(v[1], v[0]), subtract(v[2], v[0]));
    const Wide slope = dot(n, d);
    std::optional<Stretch> stretch;
    if (dot(n, n) == 0 || (slope == 0 && dot(n, subtract(v[0], o)) == 0)) {
        for (std::size_t i = 0; i < 3; ++i) join(stretch, meet_segment(o, d, v[i], v[(i + 1) % 3]));
        return stretch;
    }
    if (slope == 0) return std::nullopt;
    const Wide height = dot(n, subtract(v[0], o));
    for (std::size_t i = 0; i < 3; ++i) {
        const Point inward = cross(n, subtract(v[(i + 1) % 3], v[i]));
        // inward . (o + t d - v_i), t = height / slope, times slope.
        const Wide side = dot(inward, subtract(o, v[i])) * slope + dot(inward, d) * height;
        if ((slope > 0 ? side : -side) < 0) return std::nullopt;
    }
    const Fraction t = fraction(height, slope);
    return Stretch{t, t};
}

Vec3 to_double(const Point& p)
{
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}
Vec3 to_double(const Point& p, const Vec3& scale)
{
    return scale.cwiseProduct(to_double(p));
}

class Numbers {
public:
    explicit Numbers(std::uint64_t seed) : random_(seed) {}
    Point operator()(std::int64_t reach)
    {
        Point p;
        for (std::int64_t& x : p) {
            x = static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(2 * reach + 1)) -
                reach;
        }
        return p;
    }

private:
    std::mt19937_64 random_;
};

struct Grid {
    Vec3 scale; ///< by axis: neither t, u and v nor a side that shows depend on it
    std::size_t rays;
};

TEST(RayTriangle, AgreesWithExactIntegersOnSmallGrids)
{
    constexpr std::size_t many = 60'000;
    constexpr std::size_t few = 6'000; // where numbers of a thousand bits are needed
    for (const auto& [scale, rays] :
         {Grid{Vec3::Constant(1), many}, Grid{Vec3::Constant(0x1p-20), many},
          Grid{Vec3::Constant(0x1p20), many}, Grid{Vec3::Constant(0x1p-400), many},
          Grid{Vec3::Constant(0x1p300), many}, Grid{Vec3::Constant(0x1p509), few},
          Grid{Vec3::Constant(0x1p511), few}, Grid{Vec3(0x1p-1074, 1, 1), few},
          Grid{Vec3(1, 0x1p-1000, 0x1p300), few}, Grid{Vec3(0x1p-350, 0x1p-30, 0x1p-1060), few}}) {
        constexpr std::uint64_t seed = 3;
        SCOPED_TRACE(::testing::Message() << "seed " << seed << " scale " << scale.transpose());
        Numbers number(seed);
        std::size_t hits = 0;
        std::size_t flat = 0;
        for (std::size_t i = 0; i < rays; ++i) {
            const std::int64_t reach = i % 2 == 0 ? 1 : 4;
            const IntegerTriangle whole{{number(reach), number(reach), number(reach)}};
            const Point o = number(reach);
            const Point d = number(reach);
            if (d == Point{}) continue;
            const auto truth = meet_triangle(o, d, whole);
            const Triangle triangle{{to_double(whole.vertices[0], scale),
                                     to_double(whole.vertices[1], scale),
                                     to_double(whole.vertices[2], scale)}};
            Ray ray{to_double(o, scale), to_double(d, scale)};
            ray.t_min = -HUGE_VAL;
            const auto hit = intersect(ray, triangle);
            ASSERT_EQ(hit.has_value(), truth.has_value()) << i;
            if (!truth) continue;
            ++hits;
            ASSERT_NEAR(hit->t, truth->first.value(), 1e-14) << i;
            if (!(truth->first < truth->last)) {
                const Wide zero = truth->first.numerator;
                ASSERT_EQ(hit->t > 0, zero > 0) << i;
                ASSERT_EQ(hit->t < 0, zero < 0) << i;
            }
            ASSERT_GE(std::min(hit->u, hit->v), 0);
            ASSERT_LE(hit->u + hit->v, 1 + 1e-15);
            const Vec3 p =
                (1 - hit->u - hit->v) * triangle[0] + hit->u * triangle[1] + hit->v * triangle[2];
            const Vec3 off = (p - ray.at(hit->t)).cwiseAbs();
            for (int axis = 0; axis < 3; ++axis)
                ASSERT_LE(off[axis], 1e-14 * scale[axis] * 16 + 4 * 0x1p-1074) << i;
            // One side shows, or none where it is seen edge-on.
            const Point n = cross(subtract(whole.vertices[1], whole.vertices[0]),
                                  subtract(whole.vertices[2], whole.vertices[0]));
            ASSERT_EQ(intersect(ray, triangle, Faces::front).has_value(), dot(n, d) < 0);
            ASSERT_EQ(intersect(ray, triangle, Faces::back).has_value(), dot(n, d) > 0);
            if (!(truth->first < truth->last)) continue;
            // Begun within the stretch, the ray meets the triangle where it begins.
            ++flat;
            const double middle = 0.5 * (truth->first.value() + truth->last.value());
            ray.t_min = middle;
            const auto inside = intersect(ray, triangle);
            ASSERT_TRUE(inside);
            ASSERT_EQ(inside->t, middle);
            ray.t_min = truth->last.value() + 1e-9;
            ASSERT_FALSE(intersect(ray, triangle));
        }
        EXPECT_GT(hits, rays / 12);
        EXPECT_GT(flat, rays / 120);
    }
}

TEST(RayTriangle, HitsTheTriangleThatItBeginsOn)
{
    constexpr std::uint64_t seed = 5;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    constexpr std::int64_t big = std::int64_t{1} << 26;
    Numbers number(seed);
    std::size_t inside = 0;
    std::size_t beside = 0;
    for (int i = 0; i < 40'000; ++i) {
        // Corners that eighths of them sum to whole numbers of.
        const std::int64_t reach = i % 2 == 0 ? 4 : big;
        IntegerTriangle whole{{number(reach), number(reach), number(reach)}};
        for (Point& corner : whole.vertices)
            for (std::int64_t& x : corner) x *= 8;
        const auto& [a, b, c] = whole.vertices;
        Point shares = number(8);
        for (std::int64_t& x : shares) x = std::abs(x);
        if (shares[0] + shares[1] > 8) continue;
        Point o;
        for (std::size_t k = 0; k < 3; ++k) {
            o[k] = (shares[0] * a[k] + shares[1] * b[k] + (8 - shares[0] - shares[1]) * c[k]) / 8;
        }
        Point d = number(reach);
        if (i % 5 == 0) d = subtract(b, o);
        if (d == Point{}) continue;
        const Triangle triangle{{to_double(a), to_double(b), to_double(c)}};
        const Ray ray{to_double(o), to_double(d)};
        const auto hit = intersect(ray, triangle);
        ASSERT_TRUE(hit) << i;
        ASSERT_EQ(hit->t, 0) << i;
        ASSERT_FALSE(std::signbit(hit->t)) << i;
        ++inside;
        // As near to it as doubles come, and moving off or on.
        Ray near = ray;
        const auto axis = static_cast<int>(i % 3);
        near.origin[axis] = std::nextafter(near.origin[axis], i % 7 < 3 ? -HUGE_VAL : HUGE_VAL);
        const Vec3 n = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        if (!(std::abs(n[axis]) > 1e-3 * n.norm()) || near.origin == ray.origin) continue;
        const double towards =
            (near.origin[axis] - ray.origin[axis]) * n[axis] * n.dot(ray.direction);
        if (!(std::abs(n.dot(ray.direction)) > 1e-3 * n.norm() * ray.direction.norm())) continue;
        // On a face, not near its border, the line still passes through.
        if (std::min({shares[0], shares[1], 8 - shares[0] - shares[1]}) == 0) continue;
        const auto close = intersect(near, triangle);
        ASSERT_EQ(close.has_value(), towards < 0) << i;
        if (close) {
            ASSERT_GT(close->t, 0) << i;
        }
        ++beside;
    }
    EXPECT_GT(inside, 10'000U);
    EXPECT_GT(beside, 5'000U);
}

TEST(RayTriangle, IsExactWhereDoublesAreNot)
{
    // A line that passes an edge by far less than any double could tell from zero by arithmetic.
    constexpr std::int64_t big = std::int64_t{1} << 26;
    Numbers number(4);
    std::size_t hits = 0;
    std::size_t misses = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Point a = number(big);
        const Point b = number(big);
        const Point c = number(big);
        Point target;
        for (std::size_t k = 0; k < 3; ++k) target[k] = (a[k] + b[k]) / 2;
        const Point o = number(big);
        const Point d = subtract(target, o);
        const auto weight = [&](const Point& p, const Point& q) {
            return dot(d, cross(subtract(p, o), subtract(q, o)));
        };
        const auto [least, most] = std::minmax({weight(a, b), weight(b, c), weight(c, a)});
        const bool truth = least >= 0 || most <= 0;
        const Ray ray{to_double(o), to_double(d)};
        const auto hit = intersect(ray, {{to_double(a), to_double(b), to_double(c)}});
        ASSERT_EQ(hit.has_value(), truth) << i;
        ++(truth ? hits : misses);
    }
    EXPECT_GT(hits, 4000U);
    EXPECT_GT(misses, 2000U);
}

TEST(RayTriangle, GivesTheSameParameterOnSharedEdgesAndCorners)
{
    // Two triangles of one edge, a ray through it: the same bits, in whichever order it is named.
    Numbers number(5);
    std::size_t shared = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Vec3 a = to_double(number(64));
        const Vec3 b = a + 4 * to_double(number(16));
        const Vec3 target = 0.75 * a + 0.25 * b;
        const Vec3 o = to_double(number(64));
        const Ray ray{o, target - o};
        if (!is_valid(ray)) continue;
        const auto one = intersect(ray, {{a, b, to_double(number(64))}});
        const auto other = intersect(ray, {{to_double(number(64)), b, a}});
        if (!one || !other || one->v != 0 || other->u + other->v == 0) continue;
        ASSERT_EQ(one->t, other->t) << i;
        ++shared;
    }
    EXPECT_GT(shared, 5000U);
}

TEST(RayTriangle, KeepsToItsRange)
{
    const Triangle triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
    const auto hit = [&](double t_min, double t_max) {
        return intersect({Vec3(0.25, 0.25, -1), Vec3(0, 0, 0.5), t_min, t_max}, triangle);
    };
    EXPECT_EQ(hit(0, 2), (RayTriangleHit{2, 0.25, 0.25}));
    EXPECT_TRUE(hit(2, 2));
    EXPECT_FALSE(hit(0, std::nextafter(2.0, 0.0)));
    EXPECT_FALSE(hit(std::nextafter(2.0, 3.0), 3));
    EXPECT_TRUE(hit(-HUGE_VAL, HUGE_VAL));
}

TEST(RayTriangle, GivesFiniteAnswersWhereTinyDirectionsOverflow)
{
    constexpr double inf = HUGE_VAL;
    const Triangle flat{{Vec3(-1, -1, 0), Vec3(3, -1, 0), Vec3(-1, 3, 0)}};
    const Triangle upright{{Vec3(2, -1, -1), Vec3(2, 3, -1), Vec3(2, -1, 3)}};
    for (const double tiny : {0x1p-1074, 0x1p-1060, 0x1p-1023, 1e-300}) {
        for (const Triangle& triangle : {flat, upright}) {
            for (const double slope : {0.0, 0x1p-1074}) {
                const Ray line{Vec3(0.25, 0, 0), Vec3(tiny, slope, 0), -inf, inf};
                const auto hit = intersect(line, triangle);
                ASSERT_TRUE(hit) << tiny;
                EXPECT_LE(std::abs(hit->t), farthest_hit);
                EXPECT_GE(hit->u, 0);
                EXPECT_GE(hit->v, 0);
                EXPECT_LE(hit->u + hit->v, 1);
            }
        }
    }
}

} // namespace
} // namespace proxima::ray_triangle_test
