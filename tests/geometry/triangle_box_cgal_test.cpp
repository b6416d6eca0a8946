// The exact predicates against CGAL's exact kernel, on doubles that no integer grid reaches.
#include "geometry/exact_predicates.h"
#include "geometry/triangle_box.h"

#include <gtest/gtest.h>

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <cmath>
#include <random>

namespace proxima::triangle_box_cgal_test {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;

Kernel::Point_3 cgal_point(const Vec3& p)
{
    return {p.x(), p.y(), p.z()};
}

// CGAL's own answer; it wants triangles with area and boxes with volume.
bool cgal_overlaps(const Triangle& triangle, const Box& box)
{
    return CGAL::do_intersect(Kernel::Triangle_3(cgal_point(triangle[0]), cgal_point(triangle[1]),
                                                 cgal_point(triangle[2])),
                              Kernel::Iso_cuboid_3(cgal_point(box.lower), cgal_point(box.upper)));
}

// Boxes at many scales and offsets, and triangles through points of their surface, moved by ulps.
class NearTouching {
public:
    explicit NearTouching(std::uint64_t seed) : random_(seed) {}

    void next(Triangle& triangle, Box& box)
    {
        const double scale = std::pow(10.0, uniform(-30, 30));
        const double offset = below(2) == 0 ? 0 : scale * std::pow(10.0, uniform(0, 6));
        for (int k = 0; k < 3; ++k) {
            box.lower[k] = offset * uniform(-1, 1) + scale * uniform(-1, 1);
            box.upper[k] = box.lower[k] + scale * uniform(0.1, 1);
        }
        const auto direction = [&] {
            return Vec3(scale * uniform(-1, 1), scale * uniform(-1, 1), scale * uniform(-1, 1));
        };
        const Vec3 touched = surface_point(box);
        const Vec3 first = direction();
        const Vec3 second = direction();
        switch (below(4)) {
        case 0: // an edge passes the point
            triangle = {{touched + first, touched - uniform(0.5, 2) * first, touched + second}};
            break;
        case 1: // the plane passes the point
            triangle = {{touched + first, touched + second, touched - first - second}};
            break;
        case 2: // a corner at the point
            triangle = {{touched, touched + first, touched + second}};
            break;
        default: { // in a plane of the box, or in a coordinate of it
            const int axis = static_cast<int>(below(3));
            triangle = {{touched + first, touched + second, touched + direction()}};
            for (Vec3& vertex : triangle.vertices)
                vertex[axis] = below(4) == 0 ? vertex[axis] : touched[axis];
        }
        }
        for (Vec3& vertex : triangle.vertices)
            for (double& coordinate : vertex) coordinate = nudged(coordinate);
    }

private:
    double uniform(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(random_);
    }
    std::int64_t below(std::int64_t count)
    {
        return std::uniform_int_distribution<std::int64_t>(0, count - 1)(random_);
    }
    Vec3 surface_point(const Box& box)
    {
        Vec3 point;
        for (int k = 0; k < 3; ++k) point[k] = below(2) == 0 ? box.lower[k] : box.upper[k];
        for (std::int64_t free = below(3); free > 0; --free) {
            const auto k = static_cast<int>(below(3));
            point[k] = box.lower[k] + uniform(0, 1) * (box.upper[k] - box.lower[k]);
        }
        return point;
    }
    double nudged(double value)
    {
        switch (below(6)) {
        case 0:
            return std::nextafter(value, 1e300);
        case 1:
            return std::nextafter(value, -1e300);
        default:
            return value;
        }
    }

    std::mt19937_64 random_;
};

TEST(TriangleBoxAgainstCgal, AgreesOnNearlyTouchingDoubles)
{
    constexpr std::uint64_t seed = 91;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    NearTouching generate(seed);
    int overlapping = 0;
    int uncertain = 0;
    constexpr int cases = 100'000;
    for (int i = 0; i < cases; ++i) {
        Triangle triangle;
        Box box;
        generate.next(triangle, box);
        if (is_degenerate(triangle)) continue;
        const bool expected = cgal_overlaps(triangle, box);
        ASSERT_EQ(triangle_overlaps_box(triangle, box), expected) << "case " << i;
        const TriangleBoxVerdict verdict = triangle_box_filter(triangle, box);
        ASSERT_EQ(verdict.overlaps, expected || !verdict.certain) << "case " << i;
        overlapping += expected ? 1 : 0;
        uncertain += verdict.certain ? 0 : 1;
    }
    // The cases must be hard, and have both answers.
    EXPECT_GT(uncertain, cases / 20);
    EXPECT_GT(overlapping, cases / 4);
    EXPECT_LT(overlapping, cases - cases / 10);
}

TEST(OrientationAgainstCgal, AgreesOnNearlyFlatDoubles)
{
    constexpr std::uint64_t seed = 92;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    NearTouching generate(seed);
    for (int i = 0; i < 20'000; ++i) {
        Triangle triangle;
        Box box;
        generate.next(triangle, box);
        const Vec3& a = triangle[0];
        const Vec3& b = triangle[1];
        const Vec3& c = triangle[2];
        for (const Vec3& point : {box.lower, box.upper, Vec3(a + 2 * (b - a) - (c - a))}) {
            ASSERT_EQ(orient3d(a, b, c, point),
                      static_cast<int>(CGAL::orientation(cgal_point(a), cgal_point(b),
                                                         cgal_point(c), cgal_point(point))))
                << "case " << i;
        }
        ASSERT_EQ(is_degenerate(triangle),
                  CGAL::collinear(cgal_point(a), cgal_point(b), cgal_point(c)));
    }
}

} // namespace
} // namespace proxima::triangle_box_cgal_test
