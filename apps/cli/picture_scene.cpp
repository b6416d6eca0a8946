#include "cli/picture_scene.h"

#include "base/progress.h"
#include "cli/lamps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace proxima {

namespace {

/// Few enough triangles to be drawn in some milliseconds.
constexpr std::uint64_t triangles_per_step = 256;

/// Area-weighted vertex normals, not of unit length.
std::vector<Vec3> vertex_normals(const TriangleMesh& mesh, StageSteps& steps)
{
    std::vector<Vec3> normals(mesh.vertex_count(), Vec3::Zero());
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Vec3 normal = scaled_normal(mesh.triangle(TriangleId{i}));
        for (const std::uint32_t corner : mesh.triangles()[i]) normals[corner] += normal;
        if (!steps.done(1)) break;
    }
    return normals;
}

void draw_visible_part(Canvas& canvas, const View& view, const Triangle& triangle,
                       const std::array<Color, 3>& colors)
{
    const VisiblePart part = visible_part(view, triangle);
    std::array<ScreenVertex, 4> corners;
    for (std::size_t i = 0; i < part.count; ++i)
        corners[i] = {view.project(part.position(triangle, i)), part.color(colors, i)};
    if (part.count >= 3) canvas.draw_triangle({corners[0], corners[1], corners[2]});
    if (part.count == 4) canvas.draw_triangle({corners[0], corners[2], corners[3]});
}

/// Whether the eye sees the face of the box across an axis, the lower or the upper one.
bool is_seen(const BoxCorners& box, unsigned axis, bool upper, const Vec3& eye)
{
    const Vec3& at = box[upper ? 1U << axis : 0U];
    const Vec3 outward = box[1U << axis] - box[0];
    return (eye - at).dot(upper ? outward : Vec3(-outward)) > 0;
}

bool is_inside(const BoxCorners& box, const Vec3& eye)
{
    for (unsigned axis = 0; axis < 3; ++axis)
        if (is_seen(box, axis, false, eye) || is_seen(box, axis, true, eye)) return false;
    return true;
}

} // namespace

void draw_mesh(Canvas& canvas, const View& view, const TriangleMesh& mesh,
               const SurfaceColor& color, Progress* progress)
{
    constexpr double smooth_below = 0.7; // cosine of the angle between a face and its smooth normal
    const Color clay = srgb(0xE9E1D2);
    const Lamps lamps(view.right(), view.up(), view.back());
    StageSteps steps(progress, "drawing the mesh", 2 * mesh.triangle_count(), triangles_per_step);
    const std::vector<Vec3> normals = vertex_normals(mesh, steps);
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Color surface = color ? color(TriangleId{i}) : clay;
        const Vec3 face = scaled_normal(triangle).normalized();
        // Seen from behind, a surface is lit as if it faced the eye: open meshes show their inside.
        const double side = face.dot(view.eye() - triangle[0]) < 0.0 ? -1.0 : 1.0;
        std::array<Color, 3> colors;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3 smooth = normals[mesh.triangles()[i][corner]].normalized();
            const Vec3 normal = side * (smooth.dot(face) > smooth_below ? smooth : face);
            colors[corner] = lamps.shade(normal, surface);
        }
        draw_visible_part(canvas, view, triangle, colors);
        if (!steps.done(1)) return;
    }
}

void draw_segment(Canvas& canvas, const View& view, const Vec3& from, const Vec3& to,
                  const Color& color, const LineStyle& style)
{
    const auto part = visible_part(view, from, to);
    if (part) canvas.draw_line(view.project((*part)[0]), view.project((*part)[1]), color, style);
}

void draw_box_edges(Canvas& canvas, const View& view, const BoxCorners& box, const Color& color,
                    const LineStyle& style)
{
    const bool all = is_inside(box, view.eye());
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned b = (axis + 1) % 3;
        const unsigned c = (axis + 2) % 3;
        for (const bool upper_b : {false, true}) {
            for (const bool upper_c : {false, true}) {
                if (!all && !is_seen(box, b, upper_b, view.eye()) &&
                    !is_seen(box, c, upper_c, view.eye()))
                    continue;
                const unsigned bits = (upper_b ? 1U << b : 0U) | (upper_c ? 1U << c : 0U);
                draw_segment(canvas, view, box[bits], box[bits | 1U << axis], color, style);
            }
        }
    }
}

void hide_lines_behind(Canvas& canvas, const View& view, const BoxCorners& box)
{
    const auto hide = [&](const Triangle& triangle) {
        const VisiblePart part = visible_part(view, triangle);
        std::array<ScreenPoint, 4> corners;
        for (std::size_t i = 0; i < part.count; ++i)
            corners[i] = view.project(part.position(triangle, i));
        if (part.count >= 3) canvas.hide_lines_behind({corners[0], corners[1], corners[2]});
        if (part.count == 4) canvas.hide_lines_behind({corners[0], corners[2], corners[3]});
    };
    for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned b = 1U << (axis + 1) % 3;
        const unsigned c = 1U << (axis + 2) % 3;
        for (const bool upper : {false, true}) {
            if (!is_seen(box, axis, upper, view.eye())) continue;
            const unsigned fixed = upper ? 1U << axis : 0U;
            hide({{box[fixed], box[fixed | b], box[fixed | b | c]}});
            hide({{box[fixed], box[fixed | b | c], box[fixed | c]}});
        }
    }
}

} // namespace proxima
