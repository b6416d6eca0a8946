#include "viewer/figures/scene_figure.h"

#include "viewer/figures/figure_colors.h"

namespace proxima {

ScenePanel scene_panel(std::string title, DrawnScene scene, const OrbitCamera& camera,
                       ViewSize size)
{
    const OrbitCamera seen = framed(camera, positions_of(scene), size);
    return {std::move(title), std::move(scene), seen, size};
}

Color color_of(FacetOrigin origin)
{
    switch (origin) {
    case FacetOrigin::a:
        return srgb(0xD9534F);
    case FacetOrigin::b:
        return srgb(0x4A7FD0);
    case FacetOrigin::both:
        return srgb(0x9B6BC3);
    case FacetOrigin::swept:
        break;
    }
    return srgb(0x57B57A);
}

void add_normals(DrawnScene& scene, const MinkowskiSum& sum, const DrawnSurface& surface,
                 std::span<const std::uint32_t> facets, double length, const ShapeStyle& style)
{
    for (const std::uint32_t facet : facets) {
        const Vec3 from = middle_of(surface, facet);
        add_arrow(scene, from, from + length * sum.half_space(facet).normal, 0.045 * length, style);
    }
}

Status add_polyhedron(DrawnScene& scene, const ConvexPolyhedron& polyhedron, const Vec3& offset,
                      const ShapeStyle& style, const EdgeStyle& edges, double ray_length)
{
    auto surface = draw(polyhedron, ray_length);
    if (!surface) return tl::unexpected(surface.error());
    for (Vec3& position : surface->positions) position += offset;
    const auto all = first_numbers(surface->polygon_count());
    add_polygons(scene, *surface, all, style);
    add_polygon_edges(scene, *surface, all, edges);
    return {};
}

} // namespace proxima
