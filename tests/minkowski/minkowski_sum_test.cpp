// Minkowski sums by arcs against a brute force in whole numbers: all candidate normals, all pairs.
#include "code_of.h"
#include "minkowski/whole_sum.h"
#include "polytopes.h"
#include "proxima/minkowski_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace proxima::minkowski_sum_test {
namespace {

using test::cross;
using test::dot;
using test::exact_normal;
using test::expect_euler;
using test::is_zero;
using test::operator-; // NOLINT(misc-unused-using-decls): used between vectors
using test::Points;
using test::reduced;
using test::Whole;
using test::whole;
/// Farthest points of a set along n, and how far.
struct Extreme {
    std::int64_t value;
    std::vector<Whole> points;
};
Extreme extreme_along(const std::vector<Whole>& points, const Whole& n)
{
    Extreme result = {dot(points[0], n), {}};
    for (const Whole& p : points) result.value = std::max(result.value, dot(p, n));
    for (const Whole& p : points) {
        if (dot(p, n) == result.value) result.points.push_back(p);
    }
    return result;
}

struct Operand {
    std::vector<Whole> points;
    std::vector<Whole> rays;

    explicit Operand(const ConvexPolyhedron& polyhedron)
    {
        for (const Vec3& p : polyhedron.points()) points.push_back(whole(p));
        for (const Vec3& r : polyhedron.rays()) rays.push_back(whole(r));
    }
    [[nodiscard]] std::vector<Whole> directions() const
    {
        std::vector<Whole> result = rays;
        for (const Whole& p : points) {
            for (const Whole& q : points) {
                if (p != q) result.push_back(p - q);
            }
        }
        return result;
    }
};

/// Vectors that differ in sign or length only become one.
void make_unique(std::vector<Whole>& vectors)
{
    for (Whole& v : vectors) {
        v = reduced(v);
        const auto first = std::ranges::find_if(v, [](std::int64_t c) { return c != 0; });
        if (first != v.end() && *first < 0) v = Whole{0, 0, 0} - v;
    }
    std::ranges::sort(vectors);
    vectors.erase(std::unique(vectors.begin(), vectors.end()), vectors.end());
}

/// Offsets of all facets by reduced outward normal: every plane spanned by two directions of either
/// operand, kept where the faces of both along it span an area and no ray leads beyond it.
std::map<Whole, std::int64_t> brute_force_facets(const Operand& a, const Operand& b)
{
    std::vector<Whole> lines = a.directions();
    for (const Whole& d : b.directions()) lines.push_back(d);
    make_unique(lines);
    std::vector<Whole> candidates;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const Whole n = cross(lines[i], lines[j]);
            if (!is_zero(n)) candidates.push_back(n);
        }
    }
    make_unique(candidates);
    for (std::size_t i = 0, count = candidates.size(); i < count; ++i) {
        candidates.push_back(Whole{0, 0, 0} - candidates[i]);
    }
    std::map<Whole, std::int64_t> facets;
    for (const Whole& n : candidates) {
        bool ends = true;
        std::vector<Whole> in_plane;
        for (const auto* rays : {&a.rays, &b.rays}) {
            for (const Whole& ray : *rays) {
                if (dot(ray, n) > 0) ends = false;
                if (dot(ray, n) == 0) in_plane.push_back(ray);
            }
        }
        if (!ends) continue;
        const Extreme of_a = extreme_along(a.points, n);
        const Extreme of_b = extreme_along(b.points, n);
        for (const Whole& p : of_a.points) in_plane.push_back(p - of_a.points[0]);
        for (const Whole& p : of_b.points) in_plane.push_back(p - of_b.points[0]);
        bool has_area = false;
        for (const Whole& d : in_plane) {
            for (const Whole& e : in_plane) has_area = has_area || !is_zero(cross(d, e));
        }
        if (has_area) facets[n] = of_a.value + of_b.value;
    }
    return facets;
}

/// Each facet's loop turns left at every corner about its normal and lies in its plane.
void expect_good_loops(const MinkowskiSum& sum)
{
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
        const Whole n = exact_normal(sum, f);
        const auto loop = sum.facet_loop(f);
        ASSERT_GE(loop.size(), 3U);
        const std::size_t size = loop.size();
        const auto& rest = sum.support(f);
        const std::int64_t offset =
            dot(whole(sum.a().vertex(rest.a)), n) + dot(whole(sum.b().vertex(rest.b)), n);
        std::size_t rays = 0;
        const auto edge = [&](std::size_t i) { // direction of the boundary after corner i
            const std::uint32_t from = loop[i % size];
            const std::uint32_t to = loop[(i + 1) % size];
            if (sum.is_ray(to)) return whole(sum.position(to));
            if (sum.is_ray(from)) return whole(-sum.position(from));
            return whole(sum.position(to)) - whole(sum.position(from));
        };
        for (std::size_t i = 0; i < size; ++i) {
            const std::uint32_t v = loop[i];
            if (sum.is_ray(v)) {
                ++rays;
                EXPECT_EQ(dot(whole(sum.position(v)), n), 0);
                continue;
            }
            EXPECT_EQ(dot(whole(sum.position(v)), n), offset);
            EXPECT_GT(dot(cross(edge(i + size - 1), edge(i)), n), 0) << "facet " << f;
        }
        EXPECT_LE(rays, 2U);
    }
}

void expect_equals_brute_force(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    const auto sum = minkowski_sum(a, b);
    ASSERT_TRUE(sum) << describe(sum.error());
    const auto expected = brute_force_facets(Operand(a), Operand(b));
    std::map<Whole, std::int64_t> found;
    for (std::uint32_t f = 0; f < sum->facet_count(); ++f) {
        const Whole n = exact_normal(*sum, f);
        const auto& rest = sum->support(f);
        const std::int64_t offset =
            dot(whole(a.vertex(rest.a)), n) + dot(whole(b.vertex(rest.b)), n);
        EXPECT_TRUE(found.emplace(n, offset).second) << "two facets of one normal";
    }
    EXPECT_EQ(found, expected);
    if (sum->facet_count() > 0 && !sum->holds_line()) {
        expect_good_loops(*sum);
        expect_euler(*sum);
    }
    if (sum->facet_count() == 0 && !sum->holds_line()) {
        EXPECT_LT(sum->dimension(), 2);
    }
}

TEST(MinkowskiSum, CubeAndOctahedronMakeTwentySixFacets)
{
    const auto cube = test::hull_of(test::cube_points(1));
    const auto octahedron = test::hull_of(test::octahedron_points(1));
    EXPECT_EQ(cube.facet_count(), 6U);
    EXPECT_EQ(octahedron.facet_count(), 8U);
    const auto sum = minkowski_sum(cube, octahedron);
    ASSERT_TRUE(sum);
    std::map<FacetOrigin, int> count;
    for (std::uint32_t f = 0; f < sum->facet_count(); ++f) ++count[sum->facet(f).origin];
    EXPECT_EQ(count[FacetOrigin::a], 6);
    EXPECT_EQ(count[FacetOrigin::b], 8);
    EXPECT_EQ(count[FacetOrigin::swept], 12);
    EXPECT_EQ(sum->facet_count(), 26U);
    EXPECT_EQ(sum->vertex_count(), 24U);
    EXPECT_EQ(sum->edges().size(), 48U);
    expect_equals_brute_force(cube, octahedron);
}

TEST(MinkowskiSum, EqualsBruteForceOnNastyShapes)
{
    for (unsigned seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto a = test::hull_of(test::nasty_points(random));
        const auto b = test::hull_of(test::nasty_points(random));
        expect_equals_brute_force(a, b);
        if (HasFailure()) break;
    }
}

TEST(MinkowskiSum, EqualsBruteForceOnNastyUnboundedShapes)
{
    int lines = 0;
    for (unsigned seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const auto unbounded = [&] {
            while (true) {
                const Points points = test::nasty_points(random);
                Points rays = test::whole_points(random, 1 + static_cast<int>(random() % 4), 2);
                std::erase_if(rays, [](const Vec3& ray) { return ray.isZero(0); });
                if (const auto hull = convex_hull(points, rays)) return *hull;
            }
        };
        const auto a = unbounded();
        const auto b = seed % 2 == 0 ? test::hull_of(test::nasty_points(random)) : unbounded();
        const auto sum = minkowski_sum(a, b);
        if (!sum) { // flat and with a line: refused
            EXPECT_LT(a.dimension(), 3);
            EXPECT_LT(b.dimension(), 3);
            continue;
        }
        lines += sum->holds_line() ? 1 : 0;
        expect_equals_brute_force(a, b);
        expect_equals_brute_force(b, a);
        if (HasFailure()) break;
    }
    EXPECT_GT(lines, 20);
}

Points real_points(std::mt19937& random, int count)
{
    std::uniform_real_distribution<double> coordinate(-1, 1);
    Points points(static_cast<std::size_t>(count));
    for (Vec3& p : points) {
        for (double& c : p) c = coordinate(random);
    }
    return points;
}

/// h of the sum is h of A and h of B, in any direction; on real coordinates of any size and place.
TEST(MinkowskiSum, SupportsAddUpInRandomDirections)
{
    std::size_t directions = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Points p = real_points(random, 4 + static_cast<int>(seed % 50));
        Points q = real_points(random, 4 + static_cast<int>(seed % 31));
        const double size = std::ldexp(1.0, static_cast<int>(seed % 7) * 90 - 270);
        for (Vec3& point : p) point = size * (point + Vec3(seed % 3 == 0 ? 1e6 : 0, 0, 0));
        for (Vec3& point : q) point *= size;
        const auto a = test::hull_of(p);
        const auto b = test::hull_of(q);
        const auto sum = minkowski_sum(a, b);
        ASSERT_TRUE(sum);
        expect_euler(*sum);
        // Neither the order of the operands nor where they stand changes the facets.
        const auto turned = minkowski_sum(b, a);
        EXPECT_EQ(turned->facet_count(), sum->facet_count());
        EXPECT_EQ(turned->vertex_count(), sum->vertex_count());
        std::normal_distribution<double> normal;
        for (int i = 0; i < 100; ++i) {
            const Vec3 n = Vec3{normal(random), normal(random), normal(random)}.normalized();
            double farthest = -std::numeric_limits<double>::infinity();
            for (std::uint32_t v = 0; v < sum->vertex_count(); ++v)
                farthest = std::max(farthest, n.dot(sum->position(v)));
            const double expected = a.support(n).value + b.support(n).value;
            EXPECT_NEAR(farthest / size, expected / size, 1e-9);
            ++directions;
        }
        for (std::uint32_t f = 0; f < sum->facet_count(); ++f) {
            const HalfSpace plane = sum->half_space(f);
            const double expected = a.support(plane.normal).value + b.support(plane.normal).value;
            EXPECT_NEAR(plane.offset / size, expected / size, 1e-8);
        }
    }
    EXPECT_GE(directions, 5000U);
}

TEST(MinkowskiSum, SumsPrismsOfManySidesInLinearTime)
{
    // Two coaxial prisms: one pair of caps with thousands of corners each.
    const auto prism = [](int sides, double turn) {
        Points points;
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * 3.14159265358979 * (i + turn) / sides;
            for (const double z : {-1.0, 1.0})
                points.emplace_back(std::cos(angle), std::sin(angle), z);
        }
        return test::hull_of(points);
    };
    const int sides = 3000;
    const auto sum = minkowski_sum(prism(sides, 0), prism(sides, 0.3));
    ASSERT_TRUE(sum);
    EXPECT_EQ(sum->facet_count(), 2U * sides + 2U);
    expect_euler(*sum);
}

TEST(MinkowskiSum, SumsConesOfManyRaysInTheTimeOfTheirHull)
{
    const std::uint32_t sides = 50000;
    Points rays;
    for (std::uint32_t i = 0; i < sides; ++i) {
        const double angle = 2 * 3.14159265358979 * i / sides;
        rays.emplace_back(std::cos(angle), std::sin(angle), 1);
    }
    const auto cube = test::hull_of(test::cube_points(1));
    Result<ConvexPolyhedron> cone = cube;
    const double of_hull = test::processor_time([&] {
        cone = convex_hull(Points{{0, 0, 0}}, rays);
    });
    ASSERT_EQ(cone->facet_count(), sides);
    for (const bool is_first : {true, false}) {
        const double of_sum = test::processor_time([&] {
            const auto sum = is_first ? minkowski_sum(*cone, cube) : minkowski_sum(cube, *cone);
            EXPECT_EQ(sum->vertex_count() - sum->point_count(), sides);
        });
        EXPECT_LT(of_sum, of_hull);
    }
}

TEST(MinkowskiSum, StopsOnRequest)
{
    std::mt19937 random(1);
    const auto a = test::hull_of(test::round_points(random, 40, 1e5));
    Progress progress;
    progress.cancel();
    const auto sum = minkowski_sum(a, a, {.execution = {.progress = &progress}});
    ASSERT_FALSE(sum);
    EXPECT_EQ(code_of(sum), ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::minkowski_sum_test
