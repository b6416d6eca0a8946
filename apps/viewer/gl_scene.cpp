#include "viewer/gl_scene.h"

#include "cli/lamps.h"
#include "viewer/gl_shaders.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <tuple>

namespace proxima {
namespace {

using namespace gl_shaders;

void set(const GlProgram& program, const char* name, const Eigen::Vector3f& value)
{
    glUniform3fv(glGetUniformLocation(program.name(), name), 1, value.data());
}

void set(const GlProgram& program, const char* name, float value)
{
    glUniform1f(glGetUniformLocation(program.name(), name), value);
}

void set(const GlProgram& program, const char* name, const Vec2& value)
{
    glUniform2f(glGetUniformLocation(program.name(), name), static_cast<float>(value.x()),
                static_cast<float>(value.y()));
}

void set(const GlProgram& program, const char* name, const Eigen::Matrix4d& value)
{
    const Eigen::Matrix4f floats = value.cast<float>();
    glUniformMatrix4fv(glGetUniformLocation(program.name(), name), 1, GL_FALSE, floats.data());
}

Eigen::Vector3f vector_of(const Color& color)
{
    return color.matrix();
}

/// A pair of vectors per item, as attributes 0 and 1.
GlBuffer upload_pairs(const std::vector<float>& values, GLuint divisor)
{
    constexpr GLsizei stride = 6 * sizeof(float);
    GlBuffer buffer = make_buffer();
    glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size() * sizeof(float)),
                 values.data(), GL_STATIC_DRAW);
    for (GLuint attribute = 0; attribute < 2; ++attribute) {
        glEnableVertexAttribArray(attribute);
        const std::uintptr_t offset = std::uintptr_t{3} * attribute * sizeof(float);
        // OpenGL takes an offset instead of a pointer.
        // NOLINTNEXTLINE(performance-no-int-to-ptr)
        const auto* const pointer = reinterpret_cast<const void*>(offset);
        glVertexAttribPointer(attribute, 3, GL_FLOAT, GL_FALSE, stride, pointer);
        glVertexAttribDivisor(attribute, divisor);
    }
    return buffer;
}

void append(std::vector<float>& values, const Vec3& vector)
{
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(vector[k]));
}

} // namespace

GlScene::Lines GlScene::upload_segments(const std::vector<float>& coordinates)
{
    Lines lines;
    lines.array = make_vertex_array();
    glBindVertexArray(lines.array.name());
    lines.buffer = upload_pairs(coordinates, 1);
    lines.segments = static_cast<GLsizei>(coordinates.size() / 6);
    return lines;
}

GlScene::GlScene(const DrawnScene& scene) : backdrop_{scene.background_top, scene.background_bottom}
{
    const Box box = bounding_box(scene);
    has_points_ = !box.empty();
    if (has_points_) {
        origin_ = box.center();
        radius_ = std::max(0.5 * box.extent().norm(), 1e-12);
    }
    for (const SceneSurface& from : scene.surfaces) {
        std::vector<float> values;
        values.reserve(18 * from.triangles.size());
        Vec3 sum = Vec3::Zero();
        for (const TriangleCorners& corners : from.triangles) {
            const auto& at = from.positions;
            const Vec3 face = scaled_normal({{at[corners[0]], at[corners[1]], at[corners[2]]}})
                                  .stableNormalized();
            for (const std::uint32_t corner : corners) {
                append(values, at[corner] - origin_);
                append(values, from.normals.empty() ? face : from.normals[corner]);
                sum += at[corner];
            }
        }
        Surface surface;
        surface.array = make_vertex_array();
        glBindVertexArray(surface.array.name());
        surface.buffer = upload_pairs(values, 0);
        surface.vertices = static_cast<GLsizei>(3 * from.triangles.size());
        surface.middle = sum / std::max(1.0, 3.0 * static_cast<double>(from.triangles.size()));
        surface.color = from.color;
        surface.opacity = from.opacity;
        surface.lighting = from.lighting;
        surface.lift = from.lift;
        bytes_ += values.size() * sizeof(float);
        surfaces_.push_back(std::move(surface));
    }
    for (const SceneLines& from : scene.lines) {
        std::vector<float> values;
        values.reserve(6 * from.segments.size());
        for (const auto& [start, end] : from.segments) {
            append(values, start - origin_);
            append(values, end - origin_);
        }
        Lines lines = upload_segments(values);
        lines.color = from.color;
        lines.opacity = from.opacity;
        lines.width = from.width;
        bytes_ += values.size() * sizeof(float);
        lines_.push_back(std::move(lines));
    }
}

Result<GlPainter> GlPainter::create()
{
    GlPainter painter;
    const std::array programs = {
        std::tuple{&painter.background_, background_vertices, background_colors},
        std::tuple{&painter.surface_, surface_vertices, surface_colors},
        std::tuple{&painter.line_, line_vertices, line_colors}};
    for (const auto& [program, vertices, colors] : programs) {
        auto linked = link_program(vertices, colors);
        if (!linked) return tl::unexpected(linked.error());
        *program = std::move(*linked);
    }
    painter.nothing_ = make_vertex_array();
    return painter;
}

/// One picture's camera, lamps and depth range.
class GlPainter::Frame {
public:
    Frame(const GlPainter& painter, std::span<const GlLayer> layers, const OrbitCamera& camera,
          ViewSize picture)
        : view(camera, picture), size(picture), painter_(painter),
          lamps_(view.right(), view.up(), view.back())
    {
        // The depth range is that of the scenes, so that near and far are as close as can be.
        far_ = 1e-9;
        near_ = std::numeric_limits<double>::infinity();
        for (const GlLayer& layer : layers) {
            if (!layer.scene->has_points_) continue;
            const double middle = view.depth(layer.pose(layer.scene->origin_));
            far_ = std::max(far_, middle + 1.01 * layer.scene->radius_);
            near_ = std::min(near_, middle - 1.01 * layer.scene->radius_);
        }
        near_ = std::clamp(near_, 1e-3 * far_, 0.999 * far_);
        depth_of_nearness_ =
            Vec2((far_ + near_) / (far_ - near_), -2.0 * far_ * near_ / (far_ - near_));
        world_clip_ = view.clip_from_world(near_, far_);
    }

    /// From the layer's floats to clip coordinates.
    [[nodiscard]] Eigen::Matrix4d clip(const GlLayer& layer) const
    {
        Eigen::Matrix4d world_from_local = Eigen::Matrix4d::Identity();
        world_from_local.topLeftCorner<3, 3>() = layer.pose.rotation;
        world_from_local.topRightCorner<3, 1>() = layer.pose(layer.scene->origin_);
        return world_clip_ * world_from_local;
    }

    /// What all surfaces of a layer share.
    void use_surfaces_of(const GlLayer& layer) const
    {
        const GlProgram& program = painter_.surface_;
        glUseProgram(program.name());
        set(program, "clip", clip(layer));
        set(program, "depth_of_nearness", depth_of_nearness_);
        set_cut(program, layer);
        const std::array lamps = {&lamps_.key, &lamps_.fill, &lamps_.sky};
        constexpr std::array towards = {"toward[0]", "toward[1]", "toward[2]"};
        constexpr std::array lights = {"light[0]", "light[1]", "light[2]"};
        for (std::size_t i = 0; i < lamps.size(); ++i) {
            const Vec3 toward = layer.pose.rotation.transpose() * lamps[i]->toward;
            set(program, towards[i], Eigen::Vector3f(toward.cast<float>()));
            set(program, lights[i], vector_of(lamps[i]->light));
        }
        set(program, "everywhere", vector_of(lamps_.everywhere));
    }

    void draw(const GlLayer& layer, const GlScene::Surface& surface) const
    {
        const GlProgram& program = painter_.surface_;
        set(program, "own", vector_of(layer.color.value_or(surface.color)));
        set(program, "opacity", layer.opacity * surface.opacity);
        set(program, "lift", static_cast<float>(surface.lift));
        glUniform1i(glGetUniformLocation(program.name(), "lit"),
                    surface.lighting == Lighting::lit ? 1 : 0);
        glBindVertexArray(surface.array.name());
        glDrawArrays(GL_TRIANGLES, 0, surface.vertices);
    }

    void draw(const GlLayer& layer, const GlScene::Lines& lines) const
    {
        constexpr double lift = 2e-3;
        draw(layer, lines, clip(layer), depth_of_nearness_, lift);
    }

    void draw(const GlLayer& layer, const GlScene::Lines& lines, const Eigen::Matrix4d& clip,
              const Vec2& depth_of_nearness, double lift) const
    {
        const GlProgram& program = painter_.line_;
        glUseProgram(program.name());
        set(program, "clip", clip);
        set(program, "size", Vec2(size.width, size.height));
        set(program, "width", static_cast<float>(lines.width));
        set(program, "least", static_cast<float>(view.near()));
        set(program, "lift", static_cast<float>(lift));
        set(program, "depth_of_nearness", depth_of_nearness);
        set(program, "own", vector_of(lines.color));
        set(program, "opacity", layer.opacity * lines.opacity);
        set_cut(program, layer);
        glBindVertexArray(lines.array.name());
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, lines.segments);
    }

    View view;
    ViewSize size;

private:
    const GlPainter& painter_;
    Lamps lamps_;
    double near_ = 0;
    double far_ = 0;
    Vec2 depth_of_nearness_;
    Eigen::Matrix4d world_clip_;
};

void GlPainter::draw(const GlScene& scene, const OrbitCamera& camera, ViewSize size) const
{
    const GlLayer layer = {.scene = &scene};
    draw(std::span(&layer, 1), scene.backdrop_, camera, size);
}

void GlPainter::draw(std::span<const GlLayer> layers, const Backdrop& backdrop,
                     const OrbitCamera& camera, ViewSize size) const
{
    const Frame frame(*this, layers, camera, size);
    glViewport(0, 0, size.width, size.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glEnable(GL_MULTISAMPLE);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_TRUE);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    draw_background(backdrop);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);

    struct Glass {
        const GlLayer* layer;
        const GlScene::Surface* surface;
        double depth;
    };
    std::vector<Glass> glass;
    for (const GlLayer& layer : layers) {
        frame.use_surfaces_of(layer);
        for (const GlScene::Surface& surface : layer.scene->surfaces_) {
            if (layer.opacity * surface.opacity < 1.0F) {
                const double depth = frame.view.depth(layer.pose(surface.middle));
                glass.push_back({&layer, &surface, depth});
            } else {
                frame.draw(layer, surface);
            }
        }
    }
    for (const GlLayer& layer : layers) {
        for (const GlScene::Lines& lines : layer.scene->lines_) {
            // Translucent lines write no depth, so that glass behind them is still drawn.
            glDepthMask(layer.opacity * lines.opacity < 1.0F ? GL_FALSE : GL_TRUE);
            frame.draw(layer, lines);
        }
    }

    std::ranges::stable_sort(glass, std::ranges::greater{}, &Glass::depth);
    glDepthMask(GL_FALSE);
    glEnable(GL_CULL_FACE);
    for (const Glass& pane : glass) {
        frame.use_surfaces_of(*pane.layer);
        for (const GLenum hidden : {GL_FRONT, GL_BACK}) { // the far side of each first
            glCullFace(hidden);
            frame.draw(*pane.layer, *pane.surface);
        }
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glBindVertexArray(0);
}

void GlPainter::set_cut(const GlProgram& program, const GlLayer& layer)
{
    // In the layer's floats; without a cut nothing is beyond.
    Eigen::Vector4f plane(0.0F, 0.0F, 0.0F, 1.0F);
    if (layer.cut) {
        const Vec3 normal = layer.pose.rotation.transpose() * layer.cut->normal;
        const double offset =
            layer.cut->offset - layer.cut->normal.dot(layer.pose(layer.scene->origin_));
        plane << normal.cast<float>(), static_cast<float>(offset);
    }
    glUniform4fv(glGetUniformLocation(program.name(), "cut"), 1, plane.data());
}

void GlPainter::draw_background(const Backdrop& backdrop) const
{
    glDisable(GL_DEPTH_TEST);
    glUseProgram(background_.name());
    set(background_, "top", vector_of(backdrop.top));
    set(background_, "bottom", vector_of(backdrop.bottom));
    glBindVertexArray(nothing_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

} // namespace proxima
