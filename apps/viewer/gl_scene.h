// A scene in the graphics system's memory, and how it is drawn: uploaded once, drawn from anywhere.
//
//     const auto painter = GlPainter::create();           // shaders
//     const GlScene uploaded(scene);                      // buffers
//     painter->draw(uploaded, camera, size);              // into the framebuffer that is bound
#pragma once

#include "viewer/camera.h"
#include "viewer/gl_objects.h"
#include "viewer/scene.h"

#include <vector>

namespace proxima {

/// Positions are floats relative to the middle of the scene. \pre a context is current
class GlScene {
public:
    explicit GlScene(const Scene& scene);

private:
    friend class GlPainter;

    struct Surface {
        GlVertexArray array;
        GlBuffer buffer;
        GLsizei vertices = 0;
        Vec3 middle = Vec3::Zero();
        Color color;
        float opacity = 1.0F;
        Lighting lighting = Lighting::lit;
    };
    struct Lines {
        GlVertexArray array;
        GlBuffer buffer;
        GLsizei segments = 0;
        Color color;
        float opacity = 1.0F;
        double width = 1.0;
    };

    static Lines upload_segments(const std::vector<float>& coordinates);

    Vec3 origin_ = Vec3::Zero();
    double radius_ = 1.0;
    Color background_top_;
    Color background_bottom_;
    std::vector<Surface> surfaces_;
    std::vector<Lines> lines_;
    std::vector<SceneLabel> labels_;
};

/// The shaders. Draws opaque surfaces and lines with depth, then glass from far to near.
class GlPainter {
public:
    /// Error broken_invariant where a shader does not compile. \pre a context is current
    [[nodiscard]] static Result<GlPainter> create();

    /// Into the framebuffer that is bound: its colours in sRGB, with depth.
    void draw(const GlScene& scene, const OrbitCamera& camera, ViewSize size) const;

private:
    void draw_background(const GlScene& scene) const;
    void draw_lines(const GlScene::Lines& lines, const Eigen::Matrix4d& clip, ViewSize size,
                    const Vec2& depth_of_nearness, double lift) const;
    void draw_surface(const GlScene::Surface& surface) const;
    void draw_labels(const GlScene& scene, const View& view, ViewSize size) const;

    GlProgram background_;
    GlProgram surface_;
    GlProgram line_;
    GlVertexArray nothing_;
};

} // namespace proxima
