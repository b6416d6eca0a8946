// Figures 3.12, 3.13 and 3.15: triangles and cubes.
#include "geometry/triangle_box.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/scene_figure.h"

#include <array>
#include <fmt/core.h>

namespace proxima {
namespace {

const OrbitCamera triangle_camera = {.azimuth = 0.62, .elevation = 0.38};
const Triangle summed_triangle = {
    {Vec3(-1.5, -0.5, -0.55), Vec3(1.5, -0.6, -0.2), Vec3(0.1, 0.9, 1.1)}};

Box cube_of(double half)
{
    return {Vec3::Constant(-half), Vec3::Constant(half)};
}

void add_triangle(DrawnScene& scene, const Triangle& shown, const ShapeStyle& style)
{
    DrawnSurface surface;
    surface.positions.assign(shown.vertices.begin(), shown.vertices.end());
    surface.corners = {0, 1, 2};
    surface.first = {0, 3};
    add_polygons(scene, surface, first_numbers(1), style);
    add_polygon_edges(scene, surface, first_numbers(1), thin_edges);
}

Result<MinkowskiSum> sum_with_cube(double half)
{
    const auto a = polyhedron_of_triangle(summed_triangle);
    if (!a) return tl::unexpected(a.error());
    const auto b = polyhedron_of_box(cube_of(half));
    if (!b) return tl::unexpected(b.error());
    return minkowski_sum(*a, *b);
}

/// How many facets of one sum have the normal of a facet of the other.
std::size_t shared_normals(const MinkowskiSum& one, const MinkowskiSum& other)
{
    constexpr double same = 1e-12;
    std::size_t count = 0;
    for (std::uint32_t f = 0; f < one.facet_count(); ++f) {
        for (std::uint32_t g = 0; g < other.facet_count(); ++g) {
            const Vec3 difference = one.half_space(f).normal - other.half_space(g).normal;
            if (difference.norm() > same) continue;
            ++count;
            break;
        }
    }
    return count;
}

constexpr std::array cube_halves = {0.36, 0.18};

} // namespace

Result<FigureContent> figure_3_12(const Execution& /*context*/)
{
    FigureContent content;
    content.columns = 2;
    for (const double half : cube_halves) {
        DrawnScene scene;
        add_triangle(scene, summed_triangle, {.name = "A", .color = color_of(FacetOrigin::a)});
        for (const Vec3& corner : summed_triangle.vertices) {
            const Box cube = {corner - Vec3::Constant(half), corner + Vec3::Constant(half)};
            add_box(scene, cube,
                    {.name = "copy of B", .color = color_of(FacetOrigin::b), .opacity = 0.55F});
            add_box_edges(scene, std::array{cube}, thin_edges);
        }
        content.panels.emplace_back(scene_panel(fmt::format("cubes of edge {:g}", 2 * half),
                                                std::move(scene), triangle_camera, one_of_some));
    }
    content.caption = "Copies of cubes of one octree at the corners of a triangle, of two depths: "
                      "the cubes on the right are one level deeper, half as large.";
    return content;
}

Result<FigureContent> figure_3_13(const Execution& /*context*/)
{
    FigureContent content;
    content.columns = 2;
    const auto large = sum_with_cube(cube_halves[0]);
    if (!large) return tl::unexpected(large.error());
    const auto small = sum_with_cube(cube_halves[1]);
    if (!small) return tl::unexpected(small.error());
    for (const MinkowskiSum* const sum : {&*large, &*small}) {
        const auto surface = draw(*sum);
        if (!surface) return tl::unexpected(surface.error());
        DrawnScene scene;
        for (std::uint32_t f = 0; f < sum->facet_count(); ++f) {
            add_polygons(scene, *surface, std::array{f},
                         {.name = "facet", .color = color_of(sum->facet(f).origin)});
        }
        add_polygon_edges(scene, *surface, first_numbers(sum->facet_count()), thin_edges);
        content.panels.emplace_back(scene_panel(
            fmt::format("{} facets, {} corners", sum->facet_count(), sum->point_count()),
            std::move(scene), triangle_camera, one_of_some));
    }
    content.caption = fmt::format(
        "Their Minkowski sums, each computed by itself: {} and {} facets, and {} of them share "
        "their normals. Only sizes differ, so the sum of one depth tells those of all. Red: "
        "normals of "
        "the triangle, blue: of the cube, green: swept.",
        large->facet_count(), small->facet_count(), shared_normals(*large, *small));
    return content;
}

Result<FigureContent> figure_3_15(const Execution& /*context*/)
{
    struct Case {
        const char* title;
        Triangle triangle;
    };
    // Corner 0 of each lies in the cube's upper face.
    const std::array cases = {
        Case{"goes through the volume",
             {{Vec3(-0.2, -0.1, 1), Vec3(1.5, 0.7, -0.5), Vec3(-0.7, -0.6, -0.4)}}},
        Case{"lies in the face", {{Vec3(-0.6, -0.5, 1), Vec3(0.7, -0.4, 1), Vec3(0.1, 0.6, 1)}}},
        Case{"stays outside", {{Vec3(0.0, -0.2, 1), Vec3(-0.8, 0.0, 2.1), Vec3(0.9, 0.3, 2.0)}}}};
    const Box cube = cube_of(1.0);
    constexpr double sliver = 1e-9;
    const Box inside = cube_of(1.0 - sliver);
    FigureContent content;
    std::string verdicts;
    for (const Case& shown : cases) {
        DrawnScene scene;
        add_triangle(scene, shown.triangle,
                     {.name = "triangle", .color = color_of(FacetOrigin::a)});
        add_box(scene, cube, {.name = "cube", .color = color_of(FacetOrigin::b), .opacity = 0.35F});
        add_box_edges(scene, std::array{cube}, thin_edges);
        add_ball(scene, shown.triangle[0], 0.05, {.name = "end point", .color = srgb(0x222222)});
        content.panels.emplace_back(
            scene_panel(shown.title, std::move(scene), triangle_camera, one_of_some));
        verdicts += fmt::format(" {}: {} the closed cube, {} its inside;", shown.title,
                                triangle_overlaps_box(shown.triangle, cube) ? "touches" : "misses",
                                triangle_overlaps_box(shown.triangle, inside) ? "meets" : "misses");
    }
    content.caption = fmt::format(
        "An edge ends exactly in a face of the cube (the ball): that alone does not say where the "
        "triangle goes. The exact test decides:{}.",
        std::string_view(verdicts).substr(0, verdicts.size() - 1));
    return content;
}

} // namespace proxima
