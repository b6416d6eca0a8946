// View volumes against elimination in rational numbers of any size, on doubles that no grid
// reaches.
#include "geometry/view_contact.h"

#include "geometry/test_volumes.h"
#include "oracles/half_space_system.h"

#include <gtest/gtest.h>

#include <CGAL/Exact_rational.h>

#include <random>

namespace proxima::view_contact_cgal_test {
namespace {

using namespace testing;
using Rational = CGAL::Exact_rational;

class NearVolumes : public ::testing::Test {
protected:
    static constexpr std::uint64_t seed = 9;

    /// A cloud of points, where volumes are laid about.
    std::vector<Vec3> cloud()
    {
        std::uniform_real_distribution<double> number(-1, 1);
        const double scale = std::ldexp(1.0, static_cast<int>(random() % 60) - 30);
        const double offset = random() % 3 == 0 ? 1e3 * scale : 0;
        std::vector<Vec3> points(12);
        for (Vec3& point : points) {
            const double x = number(random);
            const double y = number(random);
            point = scale * Vec3(x, y, number(random)) + Vec3::Constant(offset);
        }
        return points;
    }
    std::mt19937_64 random{seed};
};

TEST_F(NearVolumes, MeetTrianglesAsExactRationalsDo)
{
    int meets = 0;
    int passes_only = 0;
    for (int trial = 0; trial < 400; ++trial) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", trial " << trial);
        const std::vector<Vec3> points = cloud();
        VolumeGenerator generate(points, random());
        const ViewVolume volume = generate();
        if (volume.planes().size() > 12) continue;
        ASSERT_EQ(volume.empty(), oracle_is_empty<Rational>(volume.planes()));
        for (std::size_t i = 0; i + 2 < points.size(); ++i) {
            const Triangle triangle{{points[i], points[i + 1], points[i + 2]}};
            const bool truth = oracle_meets<Rational>(volume.planes(), triangle);
            ASSERT_EQ(meets_volume(volume, triangle), truth);
            meets += truth ? 1 : 0;
            passes_only += !truth && passes_planes(volume, triangle) ? 1 : 0;
        }
        Box box;
        box.extend(points[0]);
        box.extend(points[1]);
        ASSERT_EQ(meets_volume(volume, box), oracle_meets<Rational>(volume.planes(), box));
    }
    EXPECT_GT(meets, 300);
    EXPECT_GT(passes_only, 30);
}

/// Triangles through the edge of a wedge, but for rounding.
TEST_F(NearVolumes, TouchTrianglesAsExactRationalsDo)
{
    std::uniform_real_distribution<double> number(-1, 1);
    const auto any = [&] {
        const double x = number(random);
        const double y = number(random);
        return Vec3(x, y, number(random));
    };
    std::array<int, 2> seen{};
    for (int trial = 0; trial < 1500; ++trial) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", trial " << trial);
        const Vec3 touched = any();
        std::vector<ViewPlane> planes(2 + random() % 3);
        for (ViewPlane& plane : planes) {
            plane.normal = any();
            plane.offset = -plane.normal.dot(touched);
        }
        const ViewVolume volume = make_view_volume(planes).value();
        const Vec3 a = any();
        const Vec3 b = any();
        Triangle triangle{{touched + a, touched - 0.5 * a, touched + b}};
        if (trial % 3 == 1) triangle.vertices[2] = touched - a - b;
        if (trial % 3 == 2) triangle.vertices[0] = touched;
        const bool truth = oracle_meets<Rational>(planes, triangle);
        ASSERT_EQ(meets_volume(volume, triangle), truth);
        ++seen[truth ? 1 : 0];
    }
    for (const int count : seen) EXPECT_GT(count, 100);
}

} // namespace
} // namespace proxima::view_contact_cgal_test
