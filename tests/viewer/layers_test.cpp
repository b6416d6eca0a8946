// Layers: moved, cut and coloured alike by OpenGL and in one flat scene; uploaded once.
#include "base/text.h"
#include "folder_test.h"
#include "proxima/sample_meshes.h"
#include "viewer/layers.h"
#include "viewer/layers_glb.h"
#include "viewer/renderer.h"
#include "viewer/scene_shapes.h"
#ifdef PROXIMA_HAS_OPENGL
#include "viewer/egl_context.h"
#include "viewer/gl_layers.h"
#include "viewer/gl_target.h"
#endif

#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <optional>
#include <sstream>

namespace proxima::layers_test {
namespace {

std::shared_ptr<const DrawnScene> ball_scene()
{
    auto scene = std::make_shared<DrawnScene>();
    add_ball(*scene, Vec3::Zero(), 1.0, {.name = "ball", .color = srgb(0xC02020)});
    add_box_edges(*scene, std::array{Box{Vec3::Constant(-1), Vec3::Constant(1)}}, {.name = "box"});
    return scene;
}

TEST(Layers, FlattenMovesColoursAndFades)
{
    SceneLayer layer = {.scene = ball_scene(), .color = srgb(0x2040FF), .opacity = 0.5F};
    layer.pose.translation = Vec3(10, 0, 0);
    const DrawnScene scene = flattened(std::span(&layer, 1), {srgb(0x111111), srgb(0x222222)});
    EXPECT_NEAR(bounding_box(scene).center().x(), 10.0, 1e-12);
    EXPECT_TRUE((scene.surfaces[0].color == srgb(0x2040FF)).all());
    EXPECT_EQ(scene.surfaces[0].opacity, 0.5F);
    EXPECT_EQ(scene.lines[0].opacity, 0.5F);
    EXPECT_TRUE((scene.background_top == srgb(0x111111)).all());
    EXPECT_NEAR(bounding_box(std::span(&layer, 1)).center().x(), 10.0, 1e-12);
}

TEST(Layers, ACutKeepsWhatLiesInside)
{
    SceneLayer layer = {.scene = ball_scene()};
    layer.cut = HalfSpace{Vec3(0, 0, 1), 0.25};
    const DrawnScene scene = flattened(std::span(&layer, 1), {});
    double area = 0.0;
    for (const TriangleCorners& corners : scene.surfaces[0].triangles) {
        const auto& at = scene.surfaces[0].positions;
        const Triangle triangle = {{at[corners[0]], at[corners[1]], at[corners[2]]}};
        area += 0.5 * scaled_normal(triangle).norm();
        for (const Vec3& corner : triangle.vertices) EXPECT_LE(corner.z(), 0.25 + 1e-12);
    }
    EXPECT_NEAR(area, 2.0 * std::numbers::pi * 1.25, 0.06) << "a cap of height 1.25";
    for (const auto& segment : scene.lines[0].segments)
        for (const Vec3& end : segment) EXPECT_LE(end.z(), 0.25 + 1e-12);
    EXPECT_EQ(scene.lines[0].segments.size(), 8U) << "the lower square and four posts";
    EXPECT_EQ(scene.surfaces[0].normals.size(), scene.surfaces[0].positions.size());
}

class LayersGlb : public FolderTest {
protected:
    [[nodiscard]] std::string exported(const SceneLayer& layer)
    {
        const auto path = folder() / "shown.glb";
        EXPECT_TRUE(export_scene(flattened(std::span(&layer, 1), {}), path));
        std::ostringstream text;
        text << std::ifstream(path, std::ios::binary).rdbuf();
        return text.str();
    }
};

TEST_F(LayersGlb, HoldsEverySurfaceAndLine)
{
    const std::string bytes = exported({.scene = ball_scene()});
    ASSERT_GT(bytes.size(), 20U);
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_NE(bytes.find(R"("name":"ball")"), std::string::npos);
    EXPECT_NE(bytes.find(R"("name":"box")"), std::string::npos);
    EXPECT_NE(bytes.find(concat("\"count\":", 3 * 1280)), std::string::npos) << "indices";
}

TEST_F(LayersGlb, IsAsTransparentAsThePicture)
{
    const std::string blended = R"("doubleSided":true,"alphaMode":"BLEND",)";
    EXPECT_EQ(exported({.scene = ball_scene()}).find("alphaMode"), std::string::npos);
    const std::string bytes = exported({.scene = ball_scene(), .opacity = 0.25F});
    for (const char* name : {R"("name":"ball",)", R"("name":"box",)"}) {
        const std::size_t at = bytes.find(name + blended);
        ASSERT_NE(at, std::string::npos) << name;
        const std::size_t color = bytes.find("\"baseColorFactor\":[", at);
        EXPECT_EQ(bytes.substr(bytes.find(']', color) - 5, 5), ",0.25") << name;
    }
}

#ifdef PROXIMA_HAS_OPENGL

/// How many bytes of two pictures differ by more than a little.
double difference(const Image& one, const Image& other)
{
    std::size_t different = 0;
    for (std::size_t i = 0; i < one.bytes.size(); ++i)
        if (std::abs(int{one.bytes[i]} - int{other.bytes[i]}) > 24) ++different;
    return static_cast<double>(different) / static_cast<double>(one.bytes.size());
}

class GlLayersTest : public ::testing::Test {
protected:
    void SetUp() override
    {
        auto created = EglContext::create();
        if (!created) GTEST_SKIP() << describe(created.error());
        context_.emplace(std::move(*created));
    }
    void TearDown() override
    {
        if (!context_) return;
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    }

private:
    std::optional<EglContext> context_;
};

TEST_F(GlLayersTest, UploadsEachSceneOnce)
{
    GlLayers uploaded;
    std::vector<SceneLayer> layers = {{.scene = ball_scene()}, {.scene = ball_scene()}};
    layers.push_back(layers.front()); // the same scene twice
    ASSERT_TRUE(uploaded.show(layers));
    EXPECT_EQ(uploaded.uploads(), 2U);
    const std::size_t bytes = uploaded.uploaded_bytes();
    EXPECT_EQ(bytes, 2U * (1280U * 18U + 12U * 6U) * sizeof(float));
    for (int i = 0; i < 10; ++i) {
        layers[0].pose.translation.x() += 0.1;
        layers[1].color = srgb(0x00FF00);
        layers[1].cut = HalfSpace{Vec3(1, 0, 0), 0.1 * i};
        ASSERT_TRUE(uploaded.show(layers));
    }
    EXPECT_EQ(uploaded.uploads(), 2U) << "moving, colouring and cutting upload nothing";
    EXPECT_EQ(uploaded.uploaded_bytes(), bytes);
    layers.erase(layers.begin() + 1);
    ASSERT_TRUE(uploaded.show(layers));
    layers.push_back({.scene = ball_scene()});
    ASSERT_TRUE(uploaded.show(layers));
    EXPECT_EQ(uploaded.uploads(), 3U);
}

TEST_F(GlLayersTest, DrawsLikeTheSoftwareRenderer)
{
    SceneLayer moved = {.scene = ball_scene(), .color = srgb(0x3070D0)};
    moved.pose.rotation = Eigen::AngleAxisd(0.6, Vec3::UnitX()).toRotationMatrix();
    moved.pose.translation = Vec3(1.4, 0.4, 0.3);
    moved.cut = HalfSpace{Vec3(0, 0.6, 0.8), 0.5};
    const std::vector<SceneLayer> layers = {{.scene = ball_scene()}, moved};
    const Backdrop backdrop = {srgb(0x445566), srgb(0x112233)};
    constexpr ViewSize size = {.width = 320, .height = 240};
    const OrbitCamera camera = framed({.azimuth = 0.5, .elevation = 0.3, .zoom = 2.2},
                                      corners(bounding_box(layers)), size);

    GlLayers uploaded;
    ASSERT_TRUE(uploaded.show(layers));
    const auto painter = GlPainter::create();
    ASSERT_TRUE(painter);
    auto fine = GlTarget::create();
    auto window = GlTarget::create(); // stands for a window's framebuffer
    ASSERT_TRUE(fine && window);
    ASSERT_TRUE(window->bind(size, 1));
    GLint window_frame = 0;
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &window_frame);
    ASSERT_TRUE(fine->bind(size, 4));
    painter->draw(uploaded.layers(), backdrop, camera, size);
    fine->show(static_cast<GLuint>(window_frame), 0, 0);
    Image image{size.width, size.height, {}};
    image.bytes.resize(3U * 320U * 240U);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    std::vector<std::uint8_t> row(3U * 320U);
    for (int y = 0; y < size.height; ++y) {
        glReadPixels(0, size.height - 1 - y, size.width, 1, GL_RGB, GL_UNSIGNED_BYTE, row.data());
        std::ranges::copy(row, image.bytes.begin() + static_cast<std::ptrdiff_t>(row.size()) * y);
    }
    const auto expected =
        make_software_renderer()->render(flattened(layers, backdrop), camera, size);
    ASSERT_TRUE(expected);
    // Less than a picture changes when it is moved by a quarter of a pixel.
    OrbitCamera aside = camera;
    aside.target += 0.25 * aside.distance / (aside.zoom * 0.5 * size.height) * Vec3(1, 1, 1);
    const auto shifted = make_software_renderer()->render(flattened(layers, backdrop), aside, size);
    ASSERT_TRUE(shifted);
    EXPECT_LT(difference(image, *expected), difference(*shifted, *expected));
    const SceneLayer uncut = {.scene = moved.scene, .pose = moved.pose, .color = moved.color};
    const auto whole = make_software_renderer()->render(
        flattened(std::array{layers[0], uncut}, backdrop), camera, size);
    EXPECT_GT(difference(image, *whole), 4.0 * difference(image, *expected)) << "the cut is seen";
}

TEST_F(GlLayersTest, ShowsSmallAndFarLayersBesideOnesWithoutPoints)
{
    for (const auto& [middle, size] : std::array<std::pair<Vec3, double>, 2>{
             {{Vec3(5e5, 5e6, -300), 10}, {Vec3(0, 0, 0), 1e-5}}}) {
        auto ball = std::make_shared<DrawnScene>();
        add_ball(*ball, middle, size, {.color = srgb(0xFF0000)});
        const std::vector<SceneLayer> layers = {{.scene = ball},
                                                {.scene = std::make_shared<DrawnScene>()}};
        GlLayers uploaded;
        ASSERT_TRUE(uploaded.show(layers));
        const auto painter = GlPainter::create();
        auto target = GlTarget::create();
        ASSERT_TRUE(painter && target);
        constexpr ViewSize picture = {.width = 32, .height = 32};
        ASSERT_TRUE(target->bind(picture, 1));
        const Backdrop black = {srgb(0x000000), srgb(0x000000)};
        painter->draw(uploaded.layers(), black, framed({}, corners(bounding_box(layers)), picture),
                      picture);
        std::array<std::uint8_t, 3> pixel{};
        glReadPixels(16, 16, 1, 1, GL_RGB, GL_UNSIGNED_BYTE, pixel.data());
        EXPECT_GT(int{pixel[0]}, 60) << size;
    }
}

#endif

} // namespace
} // namespace proxima::layers_test
