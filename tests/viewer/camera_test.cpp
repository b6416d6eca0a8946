#include "viewer/camera.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima {
namespace {

constexpr ViewSize size = {.width = 640, .height = 400};

std::vector<Vec3> random_points(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> coordinate(-3.0, 3.0);
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i)
        points.push_back(
            Vec3{5.0 + coordinate(random), coordinate(random), coordinate(random) - 2.0});
    return points;
}

TEST(Camera, FitsAllPointsIntoThePictureWithinItsMargin)
{
    std::mt19937_64 random(20261121);
    std::uniform_real_distribution<double> angle(-3.0, 3.0);
    for (int round = 0; round < 50; ++round) {
        const auto points = random_points(random);
        OrbitCamera camera = {.azimuth = angle(random), .elevation = 0.5 * angle(random)};
        if (round % 2 == 0) camera.up = Vec3::UnitY();
        const View view(fitted(camera, points, size, 0.1), size);
        Eigen::AlignedBox2d seen;
        for (const Vec3& point : points) {
            const ScreenPoint at = view.project(point);
            EXPECT_GT(at.nearness, 0.0);
            seen.extend(Vec2(at.x, at.y));
        }
        EXPECT_GE(seen.min().x(), 64 - 1e-6);
        EXPECT_GE(seen.min().y(), 40 - 1e-6);
        EXPECT_LE(seen.max().x(), 576 + 1e-6);
        EXPECT_LE(seen.max().y(), 360 + 1e-6);
        // One of the two directions is filled, and the middle is the picture's.
        EXPECT_TRUE(std::abs(seen.sizes().x() - 512) < 1e-6 ||
                    std::abs(seen.sizes().y() - 320) < 1e-6);
        EXPECT_NEAR(seen.center().x(), 320, 1e-6);
        EXPECT_NEAR(seen.center().y(), 200, 1e-6);
    }
}

TEST(Camera, ProjectsTheSameInOpenGlAndInSoftware)
{
    std::mt19937_64 random(7);
    for (int round = 0; round < 20; ++round) {
        const auto points = random_points(random);
        const View view(fitted({.azimuth = 0.1 * round, .elevation = 0.4}, points, size), size);
        const Eigen::Matrix4d clip = view.clip_from_world(0.1, 100.0);
        for (const Vec3& point : points) {
            const Eigen::Vector4d at = clip * point.homogeneous();
            const ScreenPoint expected = view.project(point);
            EXPECT_NEAR(0.5 * size.width * (1.0 + at.x() / at.w()), expected.x, 1e-8);
            EXPECT_NEAR(0.5 * size.height * (1.0 - at.y() / at.w()), expected.y, 1e-8);
            EXPECT_NEAR(at.w(), view.depth(point), 1e-9);
            EXPECT_LT(std::abs(at.z()), at.w());
        }
    }
}

TEST(Camera, AzimuthZeroLooksAlongYWithZUp)
{
    const View view({.azimuth = 0.0, .elevation = 0.0}, size);
    EXPECT_TRUE(view.eye().isApprox(Vec3(0, -4, 0)));
    EXPECT_TRUE(view.right().isApprox(Vec3(1, 0, 0)));
    EXPECT_TRUE(view.up().isApprox(Vec3(0, 0, 1)));
    EXPECT_LT(view.project(Vec3(0, 0, 1)).y, view.project(Vec3(0, 0, 0)).y);
    EXPECT_GT(view.project(Vec3(1, 0, 0)).x, view.project(Vec3(0, 0, 0)).x);
}

} // namespace
} // namespace proxima
