#include "viewer/renderer.h"

#include "viewer/scene_shapes.h"

#include <gtest/gtest.h>

namespace proxima {
namespace {

using Pixel = std::array<std::uint8_t, 3>;

constexpr ViewSize size = {.width = 120, .height = 100};
constexpr Pixel red = {255, 0, 0};
constexpr Pixel blue = {0, 0, 255};

/// Looks along +y at two flat squares one behind the other: red ones near, blue ones far.
class TwoSquares : public ::testing::Test {
protected:
    TwoSquares()
    {
        scene.background_top = Color::Ones();
        scene.background_bottom = Color::Ones();
        add_square(0.0, 2.0, "far", 0x0000FF);
        add_square(-1.0, 0.5, "near", 0xFF0000);
    }

    void add_square(double y, double half, const char* name, unsigned color)
    {
        SceneSurface square;
        square.name = name;
        square.positions = {{-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half}};
        square.triangles = {{0, 1, 2}, {0, 2, 3}};
        square.color = srgb(color);
        square.lighting = Lighting::flat;
        scene.surfaces.push_back(square);
    }

    [[nodiscard]] Image draw() const
    {
        const auto renderer = make_software_renderer();
        return *renderer->render(scene, fitted(camera, places_of(scene), size), size);
    }

    Scene scene;
    Camera camera = {.azimuth = 0.0, .elevation = 0.0};
};

TEST_F(TwoSquares, TheNearOneHidesTheFarOneInAnyOrder)
{
    for (int turn = 0; turn < 2; ++turn) {
        const Image image = draw();
        EXPECT_EQ(image.pixel(60, 50), red);
        EXPECT_EQ(image.pixel(60, 20), blue);
        EXPECT_EQ(image.pixel(1, 1), (Pixel{255, 255, 255}));
        std::swap(scene.surfaces[0], scene.surfaces[1]);
    }
}

TEST_F(TwoSquares, GlassLetsTheRestThroughWhicheverComesFirst)
{
    scene.surfaces[1].opacity = 0.5F;
    for (int turn = 0; turn < 2; ++turn) {
        const Image image = draw();
        // Half of the light of each, in sRGB 188.
        EXPECT_NEAR(image.pixel(60, 50)[0], 188, 2);
        EXPECT_EQ(image.pixel(60, 50)[1], 0);
        EXPECT_NEAR(image.pixel(60, 50)[2], 188, 2);
        std::swap(scene.surfaces[0], scene.surfaces[1]);
    }
}

TEST_F(TwoSquares, GlassBehindASurfaceIsNotSeen)
{
    scene.surfaces[0].opacity = 0.5F;
    EXPECT_EQ(draw().pixel(60, 50), red);
}

TEST_F(TwoSquares, LinesAreHiddenBySurfacesBeforeThemOnly)
{
    const auto line_at = [&](double y) {
        scene.lines = {{"line", {{Vec3(-2, y, 0), Vec3(2, y, 0)}}, srgb(0x00FF00), 4.0}};
        return draw();
    };
    const Image between = line_at(-0.5);
    EXPECT_EQ(between.pixel(60, 50), red);
    EXPECT_EQ(between.pixel(30, 50), (Pixel{0, 255, 0}));
    EXPECT_EQ(line_at(-1.5).pixel(60, 50), (Pixel{0, 255, 0}));
    EXPECT_EQ(line_at(1.0).pixel(30, 50), blue);
}

TEST_F(TwoSquares, LampsShadeWhatIsLit)
{
    for (SceneSurface& surface : scene.surfaces) surface.lighting = Lighting::lit;
    const Pixel before = draw().pixel(60, 50);
    EXPECT_NE(before, red);
    EXPECT_GT(before[0], 100);
    EXPECT_LT(before[1], 5);
    // From behind it is lit as well: open surfaces show their inside.
    for (TriangleCorners& triangle : scene.surfaces[1].triangles)
        std::swap(triangle[0], triangle[1]);
    EXPECT_EQ(draw().pixel(60, 50), before);
}

TEST_F(TwoSquares, WordsStandInFrontOfAll)
{
    SceneLabel label;
    label.at = Vec3(0, 1, 0);
    label.text = "W";
    label.style = {.size = 20, .color = 0x00FF00, .anchor = TextAnchor::middle};
    scene.labels.push_back(label);
    const Image image = draw();
    int green = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (image.pixel(x, y)[1] > 200 && image.pixel(x, y)[0] < 100) ++green;
    EXPECT_GT(green, 20);
}

TEST_F(TwoSquares, DrawingStopsOnRequest)
{
    Progress progress;
    progress.cancel();
    const auto renderer = make_software_renderer(&progress);
    const auto image = renderer->render(scene, camera, size);
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::cancelled);
}

TEST(SceneShapes, AreClosedSurfacesTurnedOutward)
{
    // The volume within, by the tetrahedra from the origin.
    const auto volume_of = [](const SceneSurface& surface) {
        double volume = 0.0;
        for (const auto& [a, b, c] : surface.triangles) {
            volume +=
                surface.positions[a].dot(surface.positions[b].cross(surface.positions[c])) / 6.0;
        }
        return volume;
    };
    Scene scene;
    add_box(scene, {Vec3(1, 2, 3), Vec3(2, 4, 6)}, {});
    EXPECT_DOUBLE_EQ(volume_of(scene.surfaces.back()), 6.0);
    add_ball(scene, Vec3(1, 2, 3), 0.5, {});
    EXPECT_NEAR(volume_of(scene.surfaces.back()), 4.0 / 3.0 * 3.14159 * 0.125, 0.01);
    const Box box = bounding_box(scene);
    EXPECT_TRUE(box.contains(Vec3(2, 4, 6)));
    EXPECT_TRUE(box.contains(Vec3(0.51, 2, 3)));
}

} // namespace
} // namespace proxima
