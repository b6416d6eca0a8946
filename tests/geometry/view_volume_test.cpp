#include "proxima/view_volume.h"

#include "geometry/test_volumes.h"
#include "geometry/view_plane.h"
#include "oracles/half_space_system.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace proxima::view_volume_test {
namespace {

using namespace testing;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

int sign(__int128 value)
{
    return static_cast<int>(value > 0) - static_cast<int>(value < 0);
}

TEST(ViewPlane, ClassifiesPointsLikeExactIntegers)
{
    constexpr std::uint64_t seed = 3;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::array<int, 3> seen{};
    for (int trial = 0; trial < 200000; ++trial) {
        // Half of the planes pass the point, or all but.
        const auto number = [&] {
            return static_cast<std::int64_t>(random() % (1ULL << 52U)) - (1LL << 51U);
        };
        const std::array<std::int64_t, 3> n = {number(), number(), number() % 1000};
        const std::array<std::int64_t, 3> x = {number() % 1000, number() % 1000, number()};
        __int128 value = 0;
        for (std::size_t k = 0; k < 3; ++k) value += static_cast<__int128>(n[k]) * x[k];
        ViewPlane plane;
        Vec3 point;
        for (int k = 0; k < 3; ++k) {
            plane.normal[k] = static_cast<double>(n[static_cast<std::size_t>(k)]);
            point[k] = static_cast<double>(x[static_cast<std::size_t>(k)]);
        }
        plane.offset = static_cast<double>(-value);
        if (trial % 2 != 0) {
            const double one_off = trial % 4 == 1 ? 1 : -1;
            plane.offset = std::abs(plane.offset) < 0x1p52
                               ? plane.offset + one_off
                               : std::nextafter(plane.offset, one_off * 1e30);
        }
        value += static_cast<__int128>(plane.offset);
        const int truth = sign(value);
        ++seen[static_cast<std::size_t>(truth + 1)];
        ASSERT_EQ(side_of_plane(plane, point), truth);
        // The same at the ends of the range of doubles, where expansions fail.
        for (const int shift : {-700, 600}) {
            plane.normal = plane.normal.unaryExpr([&](double v) { return std::ldexp(v, shift); });
            ASSERT_EQ(side_of_plane({plane.normal, std::ldexp(plane.offset, shift)}, point), truth);
            plane.normal = plane.normal.unaryExpr([&](double v) { return std::ldexp(v, -shift); });
            if (trial > 2000) break;
        }
    }
    for (const int count : seen) EXPECT_GT(count, 1000);
}

TEST(ViewPlane, ClassifiesMeetingPointsOfPlanes)
{
    // Through a known point of whole numbers three planes, and a fourth one.
    constexpr std::uint64_t seed = 4;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::array<int, 3> seen{};
    for (int trial = 0; trial < 20000; ++trial) {
        std::vector<ViewPlane> planes = whole_planes(random, 4, 9);
        const Vec3 point(static_cast<double>(random() % 9), static_cast<double>(random() % 9),
                         static_cast<double>(random() % 9));
        for (int i = 0; i < 3; ++i) {
            ViewPlane& plane = planes[static_cast<std::size_t>(i)];
            plane.offset = -plane.normal.dot(point);
        }
        const double independent =
            planes[0].normal.cross(planes[1].normal).dot(planes[2].normal); // exact here
        if (independent == 0) continue;
        const double value = planes[3].normal.dot(point) + planes[3].offset;
        const int truth = sign(static_cast<__int128>(value));
        ++seen[static_cast<std::size_t>(truth + 1)];
        // By numbers of other sizes, so that products of those of two planes over- or underflow.
        using Shifts = std::array<int, 4>;
        for (const Shifts& shifts :
             {Shifts{0, 0, 0, 0}, Shifts{-900, -900, -900, -900}, Shifts{900, 900, 900, 900},
              Shifts{-538, -538, 500, 500}, Shifts{500, 500, -538, -538},
              Shifts{-538, 500, -538, 500}, Shifts{-40, -40, 510, 510}, Shifts{0, 600, 600, -900},
              Shifts{-1074, -1074, 1000, 1000}}) {
            std::array<ViewPlane, 4> same;
            for (std::size_t i = 0; i < 4; ++i) {
                const double scale = std::ldexp(1.0, shifts[i]);
                same[i] = {scale * planes[i].normal, scale * planes[i].offset};
            }
            ASSERT_EQ(side_of_plane(same[3], PlaneMeeting{same[0], same[1], same[2]}), truth)
                << ::testing::PrintToString(shifts);
        }
    }
    for (const int count : seen) EXPECT_GT(count, 100);
}

TEST(ViewVolume, DetectsContradictoryPlanes)
{
    constexpr std::uint64_t seed = 5;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::array<int, 2> seen{};
    for (int trial = 0; trial < 4000; ++trial) {
        const auto planes = whole_planes(random, 1 + random() % 7, trial % 3 == 0 ? 1 : 6);
        const ViewVolume volume = make_view_volume(planes).value();
        const bool truth = oracle_is_empty<__int128>(planes);
        ++seen[truth ? 1 : 0];
        ASSERT_EQ(volume.empty(), truth) << "trial " << trial;
        if (truth) continue;
        for (const ViewPlane& plane : planes)
            ASSERT_GE(side_of_plane(plane, volume.inner_point()), 0);
    }
    for (const int count : seen) EXPECT_GT(count, 400);
}

TEST(ViewVolume, MayBeFlatOrEmptyByABit)
{
    const double third = 1.0 / 3;
    const auto slab = [&](double from, double to) {
        return make_view_volume(
                   std::vector<ViewPlane>{{Vec3(1, 1, 1), -from}, {Vec3(-1, -1, -1), to}})
            .value();
    };
    EXPECT_FALSE(slab(third, third).empty());
    EXPECT_FALSE(slab(third, std::nextafter(third, 1.0)).empty());
    EXPECT_TRUE(slab(third, std::nextafter(third, 0.0)).empty());
}

TEST(ViewVolume, RefusesInvalidPlanes)
{
    const auto code = [](std::vector<ViewPlane> planes) {
        return make_view_volume(planes).error().code;
    };
    EXPECT_EQ(code({}), ErrorCode::invalid_argument);
    EXPECT_EQ(code({{Vec3::Zero(), 1}}), ErrorCode::invalid_argument);
    EXPECT_EQ(code({{Vec3(0, nan, 1), 1}}), ErrorCode::invalid_argument);
    EXPECT_EQ(code({{Vec3(0, infinity, 1), 1}}), ErrorCode::invalid_argument);
    EXPECT_EQ(code({{Vec3(0, 0, 1), nan}}), ErrorCode::invalid_argument);
    EXPECT_EQ(code(std::vector<ViewPlane>(max_view_planes + 1)), ErrorCode::limit_exceeded);
    EXPECT_TRUE(make_view_volume(std::vector<ViewPlane>(max_view_planes)));
    const Error error =
        make_view_volume(std::vector<ViewPlane>{{Vec3::UnitX(), 0}, {Vec3::Zero(), 0}}).error();
    EXPECT_NE(error.message.find("plane 1"), std::string::npos) << error.message;
}

bool sees(const ViewVolume& volume, const Vec3& point)
{
    return std::ranges::all_of(
        volume.planes(), [&](const ViewPlane& plane) { return side_of_plane(plane, point) >= 0; });
}

TEST(PerspectiveCamera, SeesATruncatedPyramid)
{
    const auto volume = make_perspective_volume({.eye = Vec3(1, 2, 3),
                                                 .forward = Vec3(0, 0, -5),
                                                 .up = Vec3(0, 2, 7),
                                                 .field_of_view = 0.5 * std::numbers::pi,
                                                 .aspect = 2,
                                                 .near = 1,
                                                 .far = 10})
                            .value();
    ASSERT_EQ(volume.planes().size(), 6U);
    EXPECT_FALSE(volume.empty());
    // By its corners: at distance z it is 2 z high and 4 z wide.
    for (const double z : {1.0, 4.0, 10.0}) {
        for (const double x : {-1.0, 1.0}) {
            for (const double y : {-1.0, 1.0}) {
                const auto at = [&](double part, double depth) {
                    return Vec3(1 + 2 * x * part * depth, 2 + y * part * depth, 3 - depth);
                };
                const double depth = z == 1 ? z + 1e-9 : z - 1e-9;
                EXPECT_TRUE(sees(volume, at(1 - 1e-9, depth)));
                EXPECT_FALSE(sees(volume, at(1 + 1e-9, depth)));
            }
        }
    }
    EXPECT_FALSE(sees(volume, Vec3(1, 2, 3 - 1 + 1e-9)));
    EXPECT_FALSE(sees(volume, Vec3(1, 2, 3 - 10 - 1e-9)));
    EXPECT_EQ(make_perspective_volume({}).value().planes().size(), 5U);
}

TEST(OrthographicCamera, SeesABox)
{
    const auto volume = make_orthographic_volume({.eye = Vec3(1, 2, 3),
                                                  .forward = Vec3(7, 0, 0),
                                                  .up = Vec3(3, 0, 1),
                                                  .width = 2,
                                                  .height = 4,
                                                  .near = -1,
                                                  .far = 5})
                            .value();
    Box box;
    box.extend(Vec3(0, 1, 1));
    box.extend(Vec3(6, 3, 5));
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> number(-2, 8);
    for (int i = 0; i < 2000; ++i) {
        const double x = number(random);
        const double y = number(random);
        const Vec3 point(x, y, number(random));
        EXPECT_EQ(sees(volume, point), box.contains(point));
    }
}

TEST(Cameras, LookTheSameWayHoweverLongTheirDirectionIs)
{
    const auto looking = [](double length) {
        return make_orthographic_volume({.forward = Vec3(length, 2 * length, 0),
                                         .up = Vec3(0, length, length),
                                         .near = 1,
                                         .far = 2})
            .value();
    };
    const ViewVolume expected = looking(1);
    for (const double length : {0x1p-1074, 0x1p-1050, 0x1p-1022, 0x1p-600, 0x1p+600, 0x1p+1021}) {
        const ViewVolume volume = looking(length);
        ASSERT_EQ(volume.planes().size(), expected.planes().size());
        for (std::size_t i = 0; i < expected.planes().size(); ++i) {
            EXPECT_EQ(volume.planes()[i].normal, expected.planes()[i].normal) << length << ' ' << i;
            EXPECT_EQ(volume.planes()[i].offset, expected.planes()[i].offset) << length << ' ' << i;
        }
    }
}

TEST(Cameras, AreRefusedWhenTheirVolumeIsEmpty)
{
    const auto refuses = [](const auto& result) {
        return !result && result.error().code == ErrorCode::invalid_argument &&
               result.error().where == "camera";
    };
    const auto perspective = make_perspective_volume;
    EXPECT_TRUE(refuses(perspective({.forward = Vec3::Zero()})));
    EXPECT_TRUE(refuses(perspective({.forward = Vec3(0, nan, 1)})));
    EXPECT_TRUE(refuses(perspective({.eye = Vec3(0, infinity, 1)})));
    EXPECT_TRUE(refuses(perspective({.up = Vec3::Zero()})));
    EXPECT_TRUE(refuses(perspective({.up = Vec3(0, nan, 1)})));
    EXPECT_TRUE(refuses(perspective({.forward = Vec3(1, 2, 3), .up = Vec3(-2, -4, -6)})));
    for (const double angle : {0.0, -1.0, std::numbers::pi, 4.0, nan})
        EXPECT_TRUE(refuses(perspective({.field_of_view = angle})));
    for (const double aspect : {0.0, -1.0, infinity, nan})
        EXPECT_TRUE(refuses(perspective({.aspect = aspect})));
    for (const double near : {0.0, -1.0, infinity, nan})
        EXPECT_TRUE(refuses(perspective({.near = near})));
    EXPECT_TRUE(refuses(perspective({.near = 1, .far = 1})));
    EXPECT_TRUE(refuses(perspective({.near = 1, .far = nan})));
    const auto orthographic = make_orthographic_volume;
    for (const double length : {0.0, -1.0, infinity, nan}) {
        EXPECT_TRUE(refuses(orthographic({.width = length})));
        EXPECT_TRUE(refuses(orthographic({.height = length})));
    }
    EXPECT_TRUE(refuses(orthographic({.near = 2, .far = 1})));
    EXPECT_TRUE(refuses(orthographic({.up = Vec3(0, 0, 2)})));
    EXPECT_TRUE(orthographic({.near = -2, .far = -1}));
}

} // namespace
} // namespace proxima::view_volume_test
