// What a figure or a window shows: surfaces and lines in space. Nothing of how it is drawn.
//
//     DrawnScene scene;
//     add_mesh(scene, mesh, {.name = "mesh"});              // scene_shapes.h
//     add_box(scene, cell, {.color = srgb(0xFFE23D)});
//     const OrbitCamera camera = framed({.azimuth = 0.5}, scene, size);
//     renderer.render(scene, camera, size);
#pragma once

#include "cli/canvas.h"
#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <string>
#include <vector>

namespace proxima {

/// Whether lamps shade a surface, or it shows its colour as it is.
enum class Lighting { lit, flat };

/// Triangles of one colour.
struct SceneSurface {
    std::string name; ///< of what it shows, for whoever looks for it
    std::vector<Vec3> positions;
    std::vector<Vec3> normals; ///< one per position, or none: every triangle is flat
    std::vector<TriangleCorners> triangles;
    Color color = Color::Ones();
    float opacity = 1.0F;
    Lighting lighting = Lighting::lit;
    double lift = 0.0; ///< how much nearer it counts, as part: over a surface that it lies on
};

/// Segments of one colour.
struct SceneLines {
    std::string name;
    std::vector<std::array<Vec3, 2>> segments;
    Color color = Color::Zero();
    double width = 1.5; ///< pixels
    float opacity = 1.0F;
};

struct DrawnScene {
    Color background_top = srgb(0xFBFCFE);
    Color background_bottom = srgb(0xE3E8EF);
    float creases = 0.0F; ///< how dark creases are, 0 to 1
    std::vector<SceneSurface> surfaces = {};
    std::vector<SceneLines> lines = {};
};

/// Of surfaces and lines; empty without any.
[[nodiscard]] Box bounding_box(const DrawnScene& scene);

/// All points that a camera must show: corners of surfaces and ends of lines.
[[nodiscard]] std::vector<Vec3> positions_of(const DrawnScene& scene);

} // namespace proxima
