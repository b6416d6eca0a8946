#include "geometry/closest_point.h"

#include "oracles/quad_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace proxima::closest_point_test {
namespace {

using oracle::root;

/// Points of all kinds: whole ones (touching, collinear, doubled), general, slivers and needles.
class Shapes {
public:
    explicit Shapes(unsigned seed) : random_(seed) {}

    Vec3 point()
    {
        if (is_whole()) return {whole(), whole(), whole()};
        std::uniform_real_distribution<double> coordinate(-3, 3);
        return {coordinate(random_), coordinate(random_), coordinate(random_)};
    }
    Segment segment() { return {point(), point()}; }

    /// The segment turned by next to nothing, so that it is all but parallel and crosses it.
    Segment nearly_parallel(const Segment& segment)
    {
        return {segment.from + nudge(), segment.to + nudge()};
    }
    Triangle triangle()
    {
        Triangle triangle = {{point(), point(), point()}};
        if (below(3) == 0) {
            const double t = below(5) / 4.0;
            triangle.vertices[2] = triangle[0] + t * (triangle[1] - triangle[0]) + nudge();
        }
        return triangle;
    }
    Vec3 nudge()
    {
        const double size = std::pow(10.0, -below(18));
        return below(3) == 0 ? Vec3::Zero().eval() : Vec3(size * point());
    }
    int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }

private:
    bool is_whole() { return below(2) == 0; }
    double whole() { return below(7) - 3; }

    std::mt19937 random_;
};

constexpr double tolerance = 5e-15; // of coordinates up to about 6

void expect_distance(const Vec3& a, const Vec3& b, long double expected)
{
    const oracle::QuadPoint gap = oracle::QuadPoint(a) - oracle::QuadPoint(b);
    EXPECT_NEAR(static_cast<double>(root(oracle::dot(gap, gap)) - expected), 0, tolerance);
}

TEST(ClosestPoint, OnASegmentIsNearest)
{
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        Shapes shapes(seed);
        const Segment segment = shapes.segment();
        const Vec3 p =
            seed % 3 == 0 ? segment.at(shapes.below(5) / 4.0) + shapes.nudge() : shapes.point();
        const SegmentPoint closest = closest_point(segment, p);
        EXPECT_GE(closest.t, 0);
        EXPECT_LE(closest.t, 1);
        EXPECT_EQ(closest.point, segment.at(closest.t));
        expect_distance(closest.point, p,
                        root(oracle::squared_distance(p, segment.from, segment.to)));
    }
}

TEST(ClosestPoint, OnATriangleIsNearest)
{
    std::array<int, 7> parts = {};
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        Shapes shapes(seed);
        const Triangle triangle = shapes.triangle();
        Vec3 p = shapes.point();
        if (seed % 3 == 0) { // near its plane
            const double s = shapes.below(9) / 8.0;
            const double t = shapes.below(9) / 8.0;
            p = triangle[0] + s * (triangle[1] - triangle[0]) + t * (triangle[2] - triangle[0]) +
                shapes.nudge();
        }
        const TrianglePoint closest = closest_point(triangle, p);
        expect_distance(closest.point, p, root(oracle::squared_distance(p, triangle)));
        EXPECT_LE(root(oracle::squared_distance(closest.point, triangle)), tolerance);
        Vec3 weighted = Vec3::Zero();
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_GE(closest.weights[i], 0);
            weighted += closest.weights[i] * triangle.vertices[i];
        }
        EXPECT_LE((weighted - closest.point).norm(), tolerance);

        // The part named is where the weights say.
        const auto part = static_cast<std::size_t>(closest.part);
        ++parts[part];
        for (std::size_t i = 0; i < 3; ++i) {
            const bool is_zero = part == 6 ? false : part < 3 ? i != part : i == (part - 3 + 2) % 3;
            EXPECT_EQ(closest.weights[i] == 0, is_zero);
        }
    }
    for (const int count : parts) EXPECT_GT(count, 500);
}

// Their heights, as computed, are roundings along the longest side.
TEST(ClosestPoint, IsOnASideOfTrianglesWithoutAnArea)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int i = 0; i < 20'000; ++i) {
        const auto on_line = [&, across = i % 2] {
            const double along = std::ldexp(uniform(random), -static_cast<int>(random() % 60));
            return Vec3(across * along, -3.25, along);
        };
        const Triangle triangle = {{on_line(), on_line(), on_line()}};
        for (const Vec3& p : {on_line(), Vec3(on_line() + Vec3(1e-9, 1e-9, 0))}) {
            EXPECT_FALSE(closest_point_inside(triangle, p)) << i;
            EXPECT_NE(closest_point(triangle, p).part, TrianglePart::inside) << i;
        }
    }
}

TEST(ClosestPoint, OfTwoSegmentsIsNearest)
{
    int crossing = 0;
    for (unsigned seed = 0; seed < 20000; ++seed) {
        SCOPED_TRACE(seed);
        Shapes shapes(seed);
        const Segment first = shapes.segment();
        const Segment second = seed % 2 == 0 ? shapes.segment() : shapes.nearly_parallel(first);
        const SegmentPair closest = closest_points(first, second);
        EXPECT_EQ(closest.first.point, first.at(closest.first.t));
        EXPECT_EQ(closest.second.point, second.at(closest.second.t));
        expect_distance(closest.first.point, closest.second.point,
                        root(oracle::squared_distance(first, second)));
        const auto is_inside = [](double t) { return t > 0 && t < 1; };
        crossing += is_inside(closest.first.t) && is_inside(closest.second.t) ? 1 : 0;
    }
    EXPECT_GT(crossing, 1000);
}

} // namespace
} // namespace proxima::closest_point_test
