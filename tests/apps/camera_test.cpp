#include "cli/camera.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::camera_test {
namespace {

constexpr ViewSize size = {.width = 640, .height = 400};

std::vector<Vec3> random_points(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> coordinate(-3.0, 3.0);
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i) {
        points.push_back(
            Vec3{5.0 + coordinate(random), coordinate(random), coordinate(random) - 2.0});
    }
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
        const View view(framed(camera, points, size, Framing::filled, 0.1), size);
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
        // One of the two directions is filled from margin to margin.
        EXPECT_TRUE(std::abs(seen.sizes().x() - 512) < 1e-6 ||
                    std::abs(seen.sizes().y() - 320) < 1e-6);
        const View centered(framed(camera, points, size, Framing::centered, 0.1), size);
        Box box;
        for (const Vec3& point : points) box.extend(point);
        EXPECT_NEAR(centered.project(box.center()).x, 320, 1e-6);
        EXPECT_NEAR(centered.project(box.center()).y, 200, 1e-6);
        for (const Vec3& point : points) {
            const ScreenPoint at = centered.project(point);
            EXPECT_LT(std::abs(at.x - 320), 256 + 1e-6);
            EXPECT_LT(std::abs(at.y - 200), 160 + 1e-6);
        }
    }
}

TEST(Camera, LooksFromAnyEyeAtAnyTarget)
{
    std::mt19937_64 random(20261123);
    std::normal_distribution<double> coordinate(0.0, 2.0);
    const auto vector = [&] {
        return Vec3(coordinate(random), coordinate(random), coordinate(random));
    };
    for (int round = 0; round < 200; ++round) {
        OrbitCamera camera;
        camera.up = round % 4 == 0 ? Vec3(Vec3::Unit(round / 4 % 3)) : vector().normalized();
        const Vec3 target = vector();
        const Vec3 eye =
            round % 5 == 0 ? Vec3(target + (round % 2 == 0 ? 2.0 : -2.0) * camera.up) : vector();
        const View view(looking(camera, eye, target), size);
        EXPECT_LT((view.eye() - eye).norm(), 1e-12) << round;
        const ScreenPoint middle = view.project(target);
        EXPECT_NEAR(middle.x, 320, 1e-9) << round;
        EXPECT_NEAR(middle.y, 200, 1e-9) << round;
        EXPECT_GE(view.up().dot(camera.up), -1e-12) << "up is not down";
        EXPECT_NEAR(view.right().dot(camera.up), 0.0, 1e-12) << "the horizon is level";
        EXPECT_NEAR(view.right().cross(view.up()).dot(view.back()), 1.0, 1e-12);
    }
}

TEST(Camera, CutsOffWhatIsNearerThanNear)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    const View view(OrbitCamera{.distance = 0.1}, size);
    int cut = 0;
    for (int round = 0; round < 500; ++round) {
        Triangle triangle;
        for (Vec3& corner : triangle.vertices)
            corner = {coordinate(random), coordinate(random), coordinate(random)};
        const VisiblePart seen = visible_part(view, triangle);
        cut += seen.count == 4 ? 1 : 0;
        EXPECT_EQ(seen.count == 3 && seen.weights[0] == Vec3::UnitX() &&
                      seen.weights[1] == Vec3::UnitY() && seen.weights[2] == Vec3::UnitZ(),
                  is_in_front(view, triangle));
        for (int sample = 0; sample < 20; ++sample) {
            Vec3 at(part(random), part(random), part(random));
            at /= at.sum();
            const Vec3 point = at[0] * triangle[0] + at[1] * triangle[1] + at[2] * triangle[2];
            if (std::abs(view.depth(point) - view.near()) < 1e-9) continue;
            bool inside = seen.count >= 3;
            for (std::size_t i = 0; i < seen.count; ++i) {
                const Vec3& from = seen.weights[i];
                const Vec3& to = seen.weights[(i + 1) % seen.count];
                // Left of each side, in the plane of the weights.
                inside = inside && (to - from).cross(at - from).sum() >= 0.0;
            }
            EXPECT_EQ(inside, view.depth(point) > view.near()) << round;
        }
        const auto segment = visible_part(view, triangle[0], triangle[1]);
        const bool any = std::max(view.depth(triangle[0]), view.depth(triangle[1])) >= view.near();
        ASSERT_EQ(segment.has_value(), any);
        if (!segment) continue;
        for (const Vec3& end : *segment) EXPECT_GE(view.depth(end), view.near() - 1e-12);
    }
    EXPECT_GT(cut, 50);
}

TEST(Camera, ProjectsTheSameInOpenGlAndInSoftware)
{
    std::mt19937_64 random(7);
    for (int round = 0; round < 20; ++round) {
        const auto points = random_points(random);
        const View view(framed({.azimuth = 0.1 * round, .elevation = 0.4}, points, size), size);
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
} // namespace proxima::camera_test
