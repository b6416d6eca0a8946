// Meshes, boxes, arrows and balls for scenes.
#pragma once

#include "cli/camera.h"
#include "minkowski/drawn_surface.h"
#include "viewer/scene.h"

#include <array>
#include <span>
#include <string>

namespace proxima {

enum class Smoothing { flat, smooth };

struct ShapeStyle {
    std::string name = {};
    Color color = srgb(0xE9E1D2);
    float opacity = 1.0F;
    Lighting lighting = Lighting::lit;
    Smoothing smoothing = Smoothing::flat;
    double lift = 0.0;
};

struct EdgeStyle {
    std::string name = {};
    Color color = srgb(0x222222);
    double width = 1.5;
    float opacity = 1.0F;
};

/// Smooth ones get a normal per vertex, but for edges sharper than 45 degrees.
void add_mesh(DrawnScene& scene, const TriangleMesh& mesh, const ShapeStyle& style);

/// All edges between triangles that are bent by more than about a degree, and borders.
void add_mesh_edges(DrawnScene& scene, const TriangleMesh& mesh, const EdgeStyle& style);

/// The polygons named, all without names, as fans.
void add_polygons(DrawnScene& scene, const DrawnSurface& surface,
                  std::span<const std::uint32_t> polygons, const ShapeStyle& style);
void add_polygon_edges(DrawnScene& scene, const DrawnSurface& surface,
                       std::span<const std::uint32_t> polygons, const EdgeStyle& style);

void add_box(DrawnScene& scene, const Box& box, const ShapeStyle& style);
void add_box_edges(DrawnScene& scene, std::span<const Box> boxes, const EdgeStyle& style);

/// A shaft with a tip, lit. \pre from != to
void add_arrow(DrawnScene& scene, const Vec3& from, const Vec3& to, double radius,
               const ShapeStyle& style);

void add_ball(DrawnScene& scene, const Vec3& center, double radius, const ShapeStyle& style);

/// 0, 1, ..., count - 1.
[[nodiscard]] std::vector<std::uint32_t> first_numbers(std::size_t count);

/// Where the corners of a polygon are on average.
[[nodiscard]] Vec3 middle_of(const DrawnSurface& surface, std::uint32_t polygon);

} // namespace proxima
