#include "viewer/renderer.h"

#include "cli/lamps.h"
#include "code_of.h"
#include "proxima/sample_meshes.h"
#include "viewer/egl_context.h"
#include "viewer/gl_target.h"
#include "viewer/scene_shapes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

namespace proxima::renderer_test {
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
        return *renderer->render(scene, framed(camera, positions_of(scene), size), size);
    }

    DrawnScene scene;
    OrbitCamera camera = {.azimuth = 0.0, .elevation = 0.0};
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

TEST_F(TwoSquares, WhatIsLiftedHidesWhatIsInTheSamePlace)
{
    add_square(0.0, 1.8, "lifted", 0x00FF00);
    scene.surfaces[2].lift = 1e-3;
    for (const auto& [first, second] : {std::pair(0, 0), std::pair(0, 2), std::pair(0, 1)}) {
        std::swap(scene.surfaces[first], scene.surfaces[second]);
        const Image image = draw();
        EXPECT_EQ(image.pixel(60, 20), (Pixel{0, 255, 0}));
        EXPECT_EQ(image.pixel(60, 50), red); // still in front of it
    }
}

TEST_F(TwoSquares, GlassBlendsInAnyOrder)
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

TEST_F(TwoSquares, GlassBehindASurfaceIsHidden)
{
    scene.surfaces[0].opacity = 0.5F;
    EXPECT_EQ(draw().pixel(60, 50), red);
}

TEST_F(TwoSquares, OnlySurfacesInFrontHideLines)
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

TEST_F(TwoSquares, LampsShadeLitSurfacesFromBothSides)
{
    for (SceneSurface& surface : scene.surfaces) surface.lighting = Lighting::lit;
    const Pixel before = draw().pixel(60, 50);
    EXPECT_NE(before, red);
    // It faces the eye, which stands before it along -y. Its light rounds to the byte that is drawn:
    // it lies between the bytes on either side.
    const Lamps lamps(Vec3::UnitX(), Vec3::UnitZ(), -Vec3::UnitY());
    const float light = lamps.shade(-Vec3::UnitY(), srgb(0xFF0000))[0];
    EXPECT_GT(light, srgb((before[0] - 1U) << 16U)[0]);
    EXPECT_LT(light, srgb((before[0] + 1U) << 16U)[0]);
    EXPECT_EQ(before[1], 0);
    EXPECT_EQ(before[2], 0);
    // From behind it is lit as well: open surfaces show their inside.
    for (TriangleCorners& triangle : scene.surfaces[1].triangles)
        std::swap(triangle[0], triangle[1]);
    EXPECT_EQ(draw().pixel(60, 50), before);
}

TEST_F(TwoSquares, DrawingStopsOnRequest)
{
    Progress progress;
    progress.cancel();
    const auto renderer = make_software_renderer(&progress);
    const auto image = renderer->render(scene, camera, size);
    ASSERT_FALSE(image);
    EXPECT_EQ(code_of(image), ErrorCode::cancelled);
}

/// How many bytes differ by more than a little, as part of all.
double difference(const Image& one, const Image& other)
{
    std::size_t count = 0;
    for (std::size_t i = 0; i < one.bytes.size(); ++i)
        if (std::abs(one.bytes[i] - other.bytes[i]) > 24) ++count;
    return static_cast<double>(count) / static_cast<double>(one.bytes.size());
}

TEST(Renderers, OpenGlDrawsLikeSoftware)
{
    const auto opengl = make_opengl_renderer();
    if (!opengl) GTEST_SKIP() << opengl.error().message;
    DrawnScene scene;
    add_mesh(scene, make_torus(48, 24), {.smoothing = Smoothing::smooth});
    add_box(scene, {Vec3(-2, -2, -0.6), Vec3(2, 2, -0.55)}, {.color = srgb(0x7FA6C9)});
    add_box(scene, {Vec3(0.2, -1.8, -0.3), Vec3(1.4, -0.6, 0.9)},
            {.color = srgb(0x57B57A), .opacity = 0.4F});
    add_box_edges(scene, std::array{Box{Vec3(0.2, -1.8, -0.3), Vec3(1.4, -0.6, 0.9)}},
                  {.width = 3.0});
    add_arrow(scene, Vec3(0, 0, 0), Vec3(0, 0, 1.5), 0.05, {.color = srgb(0xC8373F)});
    constexpr ViewSize large = {.width = 401, .height = 303};
    const auto software = make_software_renderer();
    // Far from the origin too: floats are relative to the scene.
    for (const double away : {0.0, 1e6}) {
        for (SceneSurface& surface : scene.surfaces)
            for (Vec3& position : surface.positions) position += Vec3::Constant(away);
        for (SceneLines& lines : scene.lines) {
            for (auto& segment : lines.segments)
                for (Vec3& end : segment) end += Vec3::Constant(away);
        }
        for (const double azimuth : {0.3, 2.5}) {
            const OrbitCamera camera = framed({.azimuth = azimuth}, positions_of(scene), large);
            const auto one = software->render(scene, camera, large);
            const auto other = (*opengl)->render(scene, camera, large);
            ASSERT_TRUE(one);
            ASSERT_TRUE(other) << other.error().message;
            ASSERT_EQ(one->bytes.size(), other->bytes.size());
            // Less than a picture changes when it is moved by a quarter of a pixel.
            OrbitCamera aside = camera;
            aside.target +=
                0.25 * aside.distance / (aside.zoom * 0.5 * large.height) * Vec3(1, 1, 1);
            const auto moved = software->render(scene, aside, large);
            ASSERT_TRUE(moved);
            EXPECT_LT(difference(*one, *other), difference(*one, *moved));
        }
    }
    // Another camera is another picture: the measure can tell.
    const OrbitCamera here = framed({.azimuth = 0.3}, positions_of(scene), large);
    const OrbitCamera there = framed({.azimuth = 0.6}, positions_of(scene), large);
    EXPECT_GT(
        difference(*software->render(scene, here, large), *(*opengl)->render(scene, there, large)),
        0.05);
}

TEST(Renderers, OpenGlDrawsLinesOfModelsOfAnySize)
{
    const auto opengl = make_opengl_renderer();
    if (!opengl) GTEST_SKIP() << opengl.error().message;
    const auto software = make_software_renderer();
    const auto dark = [](const Image& image) {
        return std::ranges::count_if(image.bytes, [](std::uint8_t byte) { return byte < 100; });
    };
    for (const double scale : {1e-8, 1e-5, 1.0, 1e5}) {
        DrawnScene scene;
        add_box_edges(scene, std::array{Box{Vec3::Constant(-scale), Vec3::Constant(scale)}},
                      {.width = 3.0});
        OrbitCamera camera = framed({.azimuth = 0.3}, positions_of(scene), size);
        const auto drawn = [&](Renderer& renderer) {
            return *renderer.render(scene, camera, size);
        };
        const auto expected = static_cast<double>(dark(drawn(*software)));
        EXPECT_GT(expected, 1000) << scale;
        EXPECT_NEAR(static_cast<double>(dark(drawn(**opengl))), expected, 0.2 * expected) << scale;
        // From within, some lines pass the eye.
        camera.distance = 0.5 * scale;
        const auto within = static_cast<double>(dark(drawn(*software)));
        EXPECT_GT(within, 200) << scale;
        EXPECT_NEAR(static_cast<double>(dark(drawn(**opengl))), within, 0.2 * within) << scale;
    }
}

TEST(Renderers, OpenGlTargetsRefuseASizeEachTimeThatItIsAskedFor)
{
    const auto context = EglContext::create();
    if (!context) GTEST_SKIP() << context.error().message;
    auto target = GlTarget::create();
    ASSERT_TRUE(target);
    for (int time = 0; time < 2; ++time)
        EXPECT_FALSE(target->bind({.width = 1 << 20, .height = 10}, 1)) << time;
    EXPECT_TRUE(target->bind(size, 1));
}

TEST(Renderers, OpenGlRefusesPicturesThatAreTooLarge)
{
    const auto opengl = make_opengl_renderer();
    if (!opengl) GTEST_SKIP() << opengl.error().message;
    const auto image = (*opengl)->render({}, {}, {.width = 1 << 20, .height = 10});
    ASSERT_FALSE(image);
    EXPECT_EQ(code_of(image), ErrorCode::limit_exceeded);
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
    DrawnScene scene;
    add_box(scene, {Vec3(1, 2, 3), Vec3(2, 4, 6)}, {});
    EXPECT_DOUBLE_EQ(volume_of(scene.surfaces.back()), 6.0);
    add_ball(scene, Vec3(1, 2, 3), 0.5, {});
    // Its triangles lie between its sphere and the largest ball that their planes leave.
    const SceneSurface& ball = scene.surfaces.back();
    double inner = 0.5;
    for (const auto& [a, b, c] : ball.triangles) {
        const Triangle triangle = {{ball.positions[a], ball.positions[b], ball.positions[c]}};
        const Vec3 normal = scaled_normal(triangle).stableNormalized();
        inner = std::min(inner, normal.dot(triangle[0] - Vec3(1, 2, 3)));
    }
    EXPECT_GT(inner, 0.497);
    EXPECT_GT(volume_of(ball), 4.0 / 3.0 * std::numbers::pi * std::pow(inner, 3));
    EXPECT_LT(volume_of(ball), 4.0 / 3.0 * std::numbers::pi * std::pow(0.5, 3));
    const Box box = bounding_box(scene);
    EXPECT_TRUE(box.contains(Vec3(2, 4, 6)));
    EXPECT_TRUE(box.contains(Vec3(0.51, 2, 3)));
}

} // namespace
} // namespace proxima::renderer_test
