// A scene in the graphics system's memory, and how it is drawn: uploaded once, drawn from anywhere.
//
//     const auto painter = GlPainter::create();           // shaders
//     const GlScene uploaded(scene);                      // buffers
//     painter->draw(uploaded, camera, size);              // into the framebuffer that is bound
#pragma once

#include "cli/camera.h"
#include "viewer/gl_objects.h"
#include "viewer/layers.h"
#include "viewer/scene.h"

#include <vector>

namespace proxima {

/// Positions are floats relative to the middle of the scene. \pre a context is current
class GlScene {
public:
    explicit GlScene(const DrawnScene& scene);

    /// Of the buffers.
    [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

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
        double lift = 0.0;
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

    bool has_points_ = false;
    Vec3 origin_ = Vec3::Zero();
    double radius_ = 1.0;
    std::size_t bytes_ = 0;
    Backdrop backdrop_;
    std::vector<Surface> surfaces_;
    std::vector<Lines> lines_;
};

/// An uploaded scene and how it stands: SceneLayer, but for the scene.
struct GlLayer {
    const GlScene* scene = nullptr;
    RigidTransform pose = {};
    std::optional<Color> color = {};
    float opacity = 1.0F;
    std::optional<HalfSpace> cut = {};
};

/// The shaders. Draws opaque surfaces and lines with depth, then glass from far to near.
class GlPainter {
public:
    /// Error broken_invariant where a shader does not compile. \pre a context is current
    [[nodiscard]] static Result<GlPainter> create();

    /// Into the framebuffer that is bound: its colours in sRGB, with depth.
    void draw(const GlScene& scene, const OrbitCamera& camera, ViewSize size) const;

    /// The same of several.
    void draw(std::span<const GlLayer> layers, const Backdrop& backdrop, const OrbitCamera& camera,
              ViewSize size) const;

private:
    class Frame;

    void draw_background(const Backdrop& backdrop) const;

    static void set_cut(const GlProgram& program, const GlLayer& layer);

    GlProgram background_;
    GlProgram surface_;
    GlProgram line_;
    GlVertexArray nothing_;
};

} // namespace proxima
