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

// The eye looks from the right, a little above, at a scene scaled to radius 1.
constexpr double azimuth = 0.42;   // radians from the front
constexpr double elevation = 0.30; // radians above the horizon
constexpr double eye_distance = 4.0;
constexpr double margin = 0.05; // of the picture, kept free on each side

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

} // namespace

void draw_mesh(Canvas& canvas, const Camera& camera, const TriangleMesh& mesh,
               const SurfaceColor& color, Progress* progress)
{
    constexpr double smooth_below = 0.7; // cosine of the angle between a face and its smooth normal
    const Color clay = srgb(0xE9E1D2);
    const Lamps lamps(camera.from_screen(Vec3::UnitX()), camera.from_screen(Vec3::UnitY()),
                      camera.from_screen(Vec3::UnitZ()));
    StageSteps steps(progress, "drawing the mesh", 2 * mesh.triangle_count(), triangles_per_step);
    const std::vector<Vec3> normals = vertex_normals(mesh, steps);
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Color surface = color ? color(TriangleId{i}) : clay;
        const Vec3 face = scaled_normal(triangle).normalized();
        // Seen from behind, a surface is lit as if it faced the eye: open meshes show their inside.
        const double side = face.dot(camera.eye() - triangle[0]) < 0.0 ? -1.0 : 1.0;
        std::array<ScreenVertex, 3> vertices;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3 smooth = normals[mesh.triangles()[i][corner]].normalized();
            const Vec3 normal = side * (smooth.dot(face) > smooth_below ? smooth : face);
            vertices[corner] = {camera.project(triangle.vertices[corner]),
                                lamps.shade(normal, surface)};
        }
        canvas.draw_triangle(vertices);
        if (!steps.done(1)) return;
    }
}

Camera::Camera(const Box& box, UpAxis up)
    : center_(box.center()), scale_(2.0 / std::max(box.extent().norm(), 1e-300))
{
    const bool y_up = up == UpAxis::y;
    up_ = y_up ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
    const Vec3 front = y_up ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
    const Vec3 side = up_.cross(front);
    back_ = std::cos(elevation) * (std::cos(azimuth) * front + std::sin(azimuth) * side) +
            std::sin(elevation) * up_;
    right_ = up_.cross(back_).normalized();
    up_ = back_.cross(right_);
    eye_ = center_ + eye_distance / scale_ * back_;
}

void Camera::fit(std::span<const Vec3> points, int width, int height)
{
    Eigen::AlignedBox2d seen;
    for (const Vec3& point : points) {
        const ScreenPoint at = project(point);
        seen.extend(Vec2(at.x, at.y));
    }
    const Vec2 size(width, height);
    const Vec2 inner_size = (1.0 - 2.0 * margin) * size;
    zoom_ = (inner_size.array() / seen.sizes().array().max(1e-12)).minCoeff();
    origin_ = 0.5 * size - zoom_ * seen.center();
}

ScreenPoint Camera::project(const Vec3& point) const noexcept
{
    const Vec3 offset = scale_ * (point - center_);
    const double nearness = 1.0 / (eye_distance - back_.dot(offset));
    return {origin_.x() + zoom_ * right_.dot(offset) * nearness,
            origin_.y() - zoom_ * up_.dot(offset) * nearness, nearness};
}

} // namespace proxima
