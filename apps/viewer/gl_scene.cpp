#include "viewer/gl_scene.h"

#include "cli/lamps.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>

namespace proxima {
namespace {

constexpr const char* background_vertices = R"(#version 330 core
out float part;
void main() {
    vec2 at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    part = 0.5 + 0.5 * at.y;
    gl_Position = vec4(at, 0.0, 1.0);
})";

constexpr const char* background_colors = R"(#version 330 core
in float part;
uniform vec3 top;
uniform vec3 bottom;
out vec4 color;
void main() { color = vec4(mix(bottom, top, part), 1.0); })";

constexpr const char* surface_vertices = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 clip;
out vec3 direction;
void main() {
    direction = normal;
    gl_Position = clip * vec4(position, 1.0);
})";

// As Lamps::shade has it; what is seen from behind is lit as if it faced the eye.
constexpr const char* surface_colors = R"(#version 330 core
in vec3 direction;
uniform vec3 own;
uniform float opacity;
uniform bool lit;
uniform vec3 toward[3];
uniform vec3 light[3];
uniform vec3 everywhere;
out vec4 color;
void main() {
    vec3 normal = gl_FrontFacing ? normalize(direction) : -normalize(direction);
    vec3 sum = everywhere + light[2] * (0.5 + 0.5 * dot(normal, toward[2]));
    for (int i = 0; i < 2; ++i) sum += light[i] * max(0.0, dot(normal, toward[i]));
    color = vec4(lit ? own * sum : own, opacity);
})";

// Each segment is a ribbon of four corners, cut where it passes the eye.
constexpr const char* line_vertices = R"(#version 330 core
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
uniform mat4 clip;
uniform vec2 size;
uniform float width;
uniform float lift;
uniform vec2 depth_of_nearness;
void main() {
    vec4 a = clip * vec4(from, 1.0);
    vec4 b = clip * vec4(to, 1.0);
    const float least = 1e-4;
    if (a.w < least && b.w < least) { gl_Position = vec4(0.0, 0.0, 2.0, 1.0); return; }
    if (a.w < least) a = mix(a, b, (least - a.w) / (b.w - a.w));
    if (b.w < least) b = mix(b, a, (least - b.w) / (a.w - b.w));
    vec2 along = (b.xy / b.w - a.xy / a.w) * size;
    along = length(along) > 0.0 ? normalize(along) : vec2(1.0, 0.0);
    float end = gl_VertexID < 2 ? -1.0 : 1.0;
    float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
    vec2 pixels = 0.5 * width * (side * vec2(-along.y, along.x) + 0.35 * end * along);
    vec4 at = gl_VertexID < 2 ? a : b;
    at.xy += 2.0 * pixels / size * at.w;
    if (depth_of_nearness.y != 0.0)
        at.z = depth_of_nearness.x * at.w + depth_of_nearness.y * (1.0 + lift);
    gl_Position = at;
})";

constexpr const char* line_colors = R"(#version 330 core
uniform vec3 own;
uniform float opacity;
out vec4 color;
void main() { color = vec4(own, opacity); })";

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
        // OpenGL takes an offset in the place of a pointer.
        // NOLINTNEXTLINE(performance-no-int-to-ptr)
        const auto* const place = reinterpret_cast<const void*>(offset);
        glVertexAttribPointer(attribute, 3, GL_FLOAT, GL_FALSE, stride, place);
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

GlScene::GlScene(const Scene& scene)
    : background_top_(scene.background_top), background_bottom_(scene.background_bottom),
      labels_(scene.labels)
{
    const Box box = bounding_box(scene);
    if (!box.empty()) {
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

void GlPainter::draw(const GlScene& scene, const OrbitCamera& camera, ViewSize size) const
{
    const View view(camera, size);
    // The depth range is that of the scene, so that near and far are as close as can be.
    const double middle = view.depth(scene.origin_);
    const double far = std::max(middle + 1.01 * scene.radius_, 1e-9);
    const double near = std::max(middle - 1.01 * scene.radius_, 1e-3 * far);
    Eigen::Matrix4d world_from_local = Eigen::Matrix4d::Identity();
    world_from_local.topRightCorner<3, 1>() = scene.origin_;
    const Eigen::Matrix4d clip = view.clip_from_world(near, far) * world_from_local;

    glViewport(0, 0, size.width, size.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glEnable(GL_MULTISAMPLE);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_TRUE);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    draw_background(scene);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);

    const Lamps lamps(view.right(), view.up(), view.back());
    glUseProgram(surface_.name());
    set(surface_, "clip", clip);
    const std::array places = {&lamps.key, &lamps.fill, &lamps.sky};
    constexpr std::array towards = {"toward[0]", "toward[1]", "toward[2]"};
    constexpr std::array lights = {"light[0]", "light[1]", "light[2]"};
    for (std::size_t i = 0; i < places.size(); ++i) {
        set(surface_, towards[i], Eigen::Vector3f(places[i]->toward.cast<float>()));
        set(surface_, lights[i], vector_of(places[i]->light));
    }
    set(surface_, "everywhere", vector_of(lamps.everywhere));
    std::vector<const GlScene::Surface*> glass;
    for (const GlScene::Surface& surface : scene.surfaces_) {
        if (surface.opacity < 1.0F) {
            glass.push_back(&surface);
        } else {
            draw_surface(surface);
        }
    }
    const Vec2 depth_of_nearness((far + near) / (far - near), -2.0 * far * near / (far - near));
    constexpr double lift = 2e-3;
    for (const GlScene::Lines& lines : scene.lines_)
        draw_lines(lines, clip, size, depth_of_nearness, lift);

    std::ranges::stable_sort(glass, [&](const auto* a, const auto* b) {
        return view.depth(a->middle) > view.depth(b->middle);
    });
    glDepthMask(GL_FALSE);
    glEnable(GL_CULL_FACE);
    glUseProgram(surface_.name());
    for (const GlScene::Surface* const surface : glass) {
        for (const GLenum hidden : {GL_FRONT, GL_BACK}) { // the far side of each first
            glCullFace(hidden);
            draw_surface(*surface);
        }
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glDisable(GL_DEPTH_TEST);
    draw_labels(scene, view, size);
    glBindVertexArray(0);
}

void GlPainter::draw_background(const GlScene& scene) const
{
    glDisable(GL_DEPTH_TEST);
    glUseProgram(background_.name());
    set(background_, "top", vector_of(scene.background_top_));
    set(background_, "bottom", vector_of(scene.background_bottom_));
    glBindVertexArray(nothing_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlPainter::draw_surface(const GlScene::Surface& surface) const
{
    set(surface_, "own", vector_of(surface.color));
    set(surface_, "opacity", surface.opacity);
    glUniform1i(glGetUniformLocation(surface_.name(), "lit"),
                surface.lighting == Lighting::lit ? 1 : 0);
    glBindVertexArray(surface.array.name());
    glDrawArrays(GL_TRIANGLES, 0, surface.vertices);
}

void GlPainter::draw_lines(const GlScene::Lines& lines, const Eigen::Matrix4d& clip, ViewSize size,
                           const Vec2& depth_of_nearness, double lift) const
{
    glUseProgram(line_.name());
    set(line_, "clip", clip);
    set(line_, "size", Vec2(size.width, size.height));
    set(line_, "width", static_cast<float>(lines.width));
    set(line_, "lift", static_cast<float>(lift));
    set(line_, "depth_of_nearness", depth_of_nearness);
    set(line_, "own", vector_of(lines.color));
    set(line_, "opacity", lines.opacity);
    glBindVertexArray(lines.array.name());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, lines.segments);
}

void GlPainter::draw_labels(const GlScene& scene, const View& view, ViewSize size) const
{
    // Pixels from the upper left corner to clip coordinates.
    Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
    clip(0, 0) = 2.0 / size.width;
    clip(1, 1) = -2.0 / size.height;
    clip(0, 3) = -1.0;
    clip(1, 3) = 1.0;
    for (const SceneLabel& label : scene.labels_) {
        const ScreenPoint at = view.project(label.at);
        std::vector<float> values;
        for (const auto& [from, to] : text_strokes(label.text, at.x, at.y, label.style)) {
            append(values, {from.x(), from.y(), 0.0});
            append(values, {to.x(), to.y(), 0.0});
        }
        GlScene::Lines lines = GlScene::upload_segments(values);
        lines.color = srgb(label.style.color);
        lines.width = stroke_width(label.style);
        draw_lines(lines, clip, size, Vec2::Zero(), 0.0);
    }
}

} // namespace proxima
