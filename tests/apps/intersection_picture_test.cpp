#include "cli/intersection_picture.h"

#include "cancellation.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace proxima::intersection_picture_test {
namespace {

struct Scene {
    TriangleMesh mesh = make_sphere(12, 12);
    Octree octree = *build_octree(mesh, {.max_depth = 3});
    RigidTransform pose = {Mat3::Identity(), Vec3(0.9, 0.1, 0)};
    std::vector<LeafPair> leaves = intersecting_leaves(octree, octree, pose);
    IntersectionContour contour = intersection_contour(mesh, mesh, pose, all_pairs());

    [[nodiscard]] std::vector<TrianglePair> all_pairs() const
    {
        std::vector<TrianglePair> pairs; // those that do not meet add nothing
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            for (std::uint32_t j = 0; j < mesh.triangle_count(); ++j)
                pairs.push_back({TriangleId{i}, TriangleId{j}});
        }
        return pairs;
    }
    [[nodiscard]] Result<Image> draw(Progress* progress = nullptr) const
    {
        return draw_intersection(
            {mesh, mesh, octree, octree, pose, leaves, contour},
            {.view = {.size = {200, 150}}, .execution = {.progress = progress}});
    }
};

TEST(IntersectionPicture, ShowsCellsTrianglesAndContourInTheirColours)
{
    const Scene scene;
    ASSERT_EQ(scene.contour.lines.size(), 1U);
    const Image image = scene.draw().value();
    int red = 0;
    int green = 0;
    int yellow = 0;
    int blue = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto [r, g, b] = image.pixel(x, y);
            red += r > g + 60 && r > b + 60 ? 1 : 0;
            green += g > r + 25 && g > b + 25 ? 1 : 0;
            yellow += r > b + 80 && g > b + 80 ? 1 : 0;
            blue += b > r + 25 && b > g + 25 ? 1 : 0;
        }
    }
    EXPECT_GT(red, 20);
    EXPECT_GT(green, 20);
    EXPECT_GT(yellow, 100);
    EXPECT_GT(blue, 20);
}

TEST(IntersectionPicture, StopsAtEveryStage)
{
    const Scene scene;
    testing::cancel_at_every_stage([&](Progress& progress) { return scene.draw(&progress); },
                                   [] { return true; }, 2);
}

} // namespace
} // namespace proxima::intersection_picture_test
