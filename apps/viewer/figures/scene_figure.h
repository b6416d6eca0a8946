// What figures of scenes have in common.
#pragma once

#include "proxima/minkowski_sum.h"
#include "viewer/figures/thesis_figure.h"
#include "viewer/scene_shapes.h"

#include <string>

namespace proxima {

inline constexpr ViewSize single_panel = {.width = 1000, .height = 780};
inline constexpr ViewSize one_of_some = {.width = 620, .height = 560};

inline const EdgeStyle thin_edges = {.color = srgb(0x333333), .width = 1.6};

/// The scene seen as a whole.
[[nodiscard]] ScenePanel scene_panel(std::string title, DrawnScene scene, const OrbitCamera& camera,
                                     ViewSize size);

/// Red A's, blue B's, violet both's, green swept.
[[nodiscard]] Color color_of(FacetOrigin origin);

/// The outward normals of these facets as arrows from their middles.
void add_normals(DrawnScene& scene, const MinkowskiSum& sum, const DrawnSurface& surface,
                 std::span<const std::uint32_t> facets, double length, const ShapeStyle& style);

/// The surface of a polyhedron with its edges.
[[nodiscard]] Status add_polyhedron(DrawnScene& scene, const ConvexPolyhedron& polyhedron,
                                    const Vec3& offset, const ShapeStyle& style,
                                    const EdgeStyle& edges, double ray_length = 1.0);

} // namespace proxima
