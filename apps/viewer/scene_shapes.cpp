#include "viewer/scene_shapes.h"

#include "proxima/sample_meshes.h"
#include "proxima/topology.h"

#include <cmath>
#include <numbers>
#include <numeric>

namespace proxima {
namespace {

SceneSurface& new_surface(DrawnScene& scene, const ShapeStyle& style)
{
    SceneSurface surface;
    surface.name = style.name;
    surface.color = style.color;
    surface.opacity = style.opacity;
    surface.lighting = style.lighting;
    surface.lift = style.lift;
    return scene.surfaces.emplace_back(std::move(surface));
}

SceneLines& new_lines(DrawnScene& scene, const EdgeStyle& style)
{
    return scene.lines.emplace_back(
        SceneLines{style.name, {}, style.color, style.width, style.opacity});
}

/// Positions once per corner, so that a normal may differ from triangle to triangle.
void add_smooth(SceneSurface& surface, const TriangleMesh& mesh)
{
    constexpr double smooth_below = 0.7; // cosine of the angle between a face and its smooth normal
    std::vector<Vec3> smooth(mesh.vertex_count(), Vec3::Zero());
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Vec3 normal = scaled_normal(mesh.triangle(TriangleId{i}));
        for (const std::uint32_t corner : mesh.triangles()[i]) smooth[corner] += normal;
    }
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vec3 face = scaled_normal(triangle).stableNormalized();
        const auto first = static_cast<std::uint32_t>(surface.positions.size());
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 normal = smooth[mesh.triangles()[i][k]].stableNormalized();
            surface.positions.push_back(triangle.vertices[k]);
            surface.normals.push_back(normal.dot(face) > smooth_below ? normal : face);
        }
        surface.triangles.push_back({first, first + 1, first + 2});
    }
}

constexpr std::array<std::array<std::size_t, 2>, 12> box_edges = {{{0, 1},
                                                                   {2, 3},
                                                                   {4, 5},
                                                                   {6, 7},
                                                                   {0, 2},
                                                                   {1, 3},
                                                                   {4, 6},
                                                                   {5, 7},
                                                                   {0, 4},
                                                                   {1, 5},
                                                                   {2, 6},
                                                                   {3, 7}}};

} // namespace

void add_mesh(DrawnScene& scene, const TriangleMesh& mesh, const ShapeStyle& style)
{
    SceneSurface& surface = new_surface(scene, style);
    if (style.smoothing == Smoothing::smooth) {
        add_smooth(surface, mesh);
        return;
    }
    surface.positions.assign(mesh.positions().begin(), mesh.positions().end());
    surface.triangles.assign(mesh.triangles().begin(), mesh.triangles().end());
}

void add_mesh_edges(DrawnScene& scene, const TriangleMesh& mesh, const EdgeStyle& style)
{
    constexpr double flat_cosine = 0.9998;
    SceneLines& lines = new_lines(scene, style);
    const auto topology = build_topology(mesh);
    if (!topology) return;
    for (std::uint32_t e = 0; e < topology->edge_count(); ++e) {
        const auto sides = topology->triangles(EdgeId{e});
        if (sides.size() == 2) {
            const Vec3 one = scaled_normal(mesh.triangle(sides[0])).stableNormalized();
            const Vec3 other = scaled_normal(mesh.triangle(sides[1])).stableNormalized();
            if (one.dot(other) > flat_cosine) continue;
        }
        const auto [a, b] = topology->vertices(EdgeId{e});
        lines.segments.push_back({mesh.position(a), mesh.position(b)});
    }
}

void add_polygons(DrawnScene& scene, const DrawnSurface& drawn,
                  std::span<const std::uint32_t> polygons, const ShapeStyle& style)
{
    SceneSurface& surface = new_surface(scene, style);
    surface.positions = drawn.positions;
    for (const std::uint32_t p : polygons) {
        const auto corners = drawn.polygon(p);
        for (std::size_t i = 2; i < corners.size(); ++i)
            surface.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
}

void add_polygon_edges(DrawnScene& scene, const DrawnSurface& drawn,
                       std::span<const std::uint32_t> polygons, const EdgeStyle& style)
{
    SceneLines& lines = new_lines(scene, style);
    for (const std::uint32_t p : polygons) {
        const auto corners = drawn.polygon(p);
        for (std::size_t i = 0; i < corners.size(); ++i) {
            lines.segments.push_back(
                {drawn.positions[corners[i]], drawn.positions[corners[(i + 1) % corners.size()]]});
        }
    }
}

void add_box(DrawnScene& scene, const Box& box, const ShapeStyle& style)
{
    SceneSurface& surface = new_surface(scene, style);
    for (const Vec3& corner : corners(box)) surface.positions.push_back(corner);
    for (unsigned axis = 0; axis < 3; ++axis) {
        const std::uint32_t b = 1U << ((axis + 1) % 3);
        const std::uint32_t c = 1U << ((axis + 2) % 3);
        const std::uint32_t high = 1U << axis;
        surface.triangles.push_back({0, b | c, b});
        surface.triangles.push_back({0, c, b | c});
        surface.triangles.push_back({high, high | b, high | b | c});
        surface.triangles.push_back({high, high | b | c, high | c});
    }
}

void add_box_edges(DrawnScene& scene, std::span<const Box> boxes, const EdgeStyle& style)
{
    SceneLines& lines = new_lines(scene, style);
    for (const Box& box : boxes) {
        const std::array<Vec3, 8> ends = corners(box);
        for (const auto& [from, to] : box_edges) lines.segments.push_back({ends[from], ends[to]});
    }
}

void add_arrow(DrawnScene& scene, const Vec3& from, const Vec3& to, double radius,
               const ShapeStyle& style)
{
    constexpr int sides = 20;
    const Vec3 along = to - from;
    const double length = along.norm();
    const Vec3 forward = along / length;
    const Vec3 across = forward.unitOrthogonal();
    const Vec3 other = forward.cross(across);
    const double tip = std::min(4.5 * radius, 0.6 * length);
    SceneSurface& surface = new_surface(scene, style);
    const auto put = [&](double height, double width, const Vec3& outward, const Vec3& normal) {
        surface.positions.emplace_back(from + height * forward + width * outward);
        surface.normals.push_back(normal);
        return static_cast<std::uint32_t>(surface.positions.size() - 1);
    };
    for (int i = 0; i < sides; ++i) {
        const auto outward = [&](int step) -> Vec3 {
            const double angle = 2.0 * std::numbers::pi * step / sides;
            return std::cos(angle) * across + std::sin(angle) * other;
        };
        const Vec3 one = outward(i);
        const Vec3 next = outward(i + 1);
        const double neck = length - tip;
        const auto band = [&](double low, double low_width, double high, double high_width,
                              const Vec3& tilt) {
            const std::uint32_t a = put(low, low_width, one, (one + tilt).normalized());
            const std::uint32_t b = put(low, low_width, next, (next + tilt).normalized());
            const std::uint32_t c = put(high, high_width, next, (next + tilt).normalized());
            const std::uint32_t d = put(high, high_width, one, (one + tilt).normalized());
            surface.triangles.push_back({a, b, c});
            surface.triangles.push_back({a, c, d});
        };
        band(0.0, radius, neck, radius, Vec3::Zero());
        band(neck, 2.4 * radius, length, 1e-3 * radius, 0.5 * forward);
        const std::uint32_t middle = put(neck, 0.0, one, -forward);
        const std::uint32_t rim = put(neck, 2.4 * radius, one, -forward);
        const std::uint32_t rim_next = put(neck, 2.4 * radius, next, -forward);
        surface.triangles.push_back({middle, rim_next, rim});
    }
}

void add_ball(DrawnScene& scene, const Vec3& center, double radius, const ShapeStyle& style)
{
    const TriangleMesh ball = make_icosphere(3);
    SceneSurface& surface = new_surface(scene, style);
    for (const Vec3& position : ball.positions()) {
        surface.positions.emplace_back(center + radius * position);
        surface.normals.push_back(position);
    }
    surface.triangles.assign(ball.triangles().begin(), ball.triangles().end());
}

std::vector<std::uint32_t> first_numbers(std::size_t count)
{
    std::vector<std::uint32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0U);
    return numbers;
}

Vec3 middle_of(const DrawnSurface& surface, std::uint32_t polygon)
{
    Vec3 sum = Vec3::Zero();
    const auto corners = surface.polygon(polygon);
    for (const std::uint32_t corner : corners) sum += surface.positions[corner];
    return sum / static_cast<double>(corners.size());
}

} // namespace proxima
