#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/octree_figures.h"
#include "viewer/figures/query_figures.h"
#include "viewer/figures/ray_figures.h"
#include "viewer/figures/thesis_figure.h"
#include "viewer/figures/voronoi_figures.h"

#include <array>

namespace proxima {
namespace {

constexpr auto made_figures = std::to_array<ThesisFigure>({
    {"2.3", "Uniform subdivision of a circle", figure_2_3},
    {"2.4", "Adaptive subdivision of a circle", figure_2_4},
    {"2.5", "The octree as a data structure", figure_2_5},
    {"2.6", "Adaptive octrees of a sphere", figure_2_6},
    {"2.7", "Adaptive octrees of benchmark models", nullptr, figure_2_7},
    {"3.1", "Triangle and rectangle and their normals", figure_3_1},
    {"3.2", "Convex hull of all points v_k", figure_3_2},
    {"3.3", "A line pushed along n1", figure_3_3},
    {"3.4", "Edges of the sum parallel to edges of the triangle", figure_3_4},
    {"3.5", "A line pushed along n4", figure_3_5},
    {"3.6", "Edges of the sum parallel to edges of the rectangle", figure_3_6},
    {"3.7", "Copies of B at all corners of A", figure_3_7},
    {"3.8", "Facets parallel to facets of A", figure_3_8},
    {"3.9", "Facets parallel to facets of B", figure_3_9},
    {"3.10", "Facets swept by edges of B along edges of A", figure_3_10},
    {"3.11", "The whole Minkowski sum", figure_3_11},
    {"3.12", "Copies of cubes of two sizes at the corners of a triangle", figure_3_12},
    {"3.13", "Their Minkowski sums have the same facets", figure_3_13},
    {"3.14", "Index tracking", figure_3_14},
    {"3.15", "Degenerate cases of triangle and cube", figure_3_15},
    {"3.16", "A spaceship and its octrees", figure_3_16},
    {"4.1", "Closest features listed by the cells of a quadtree", figure_4_1},
    {"4.2", "A proximity octree and a Voronoi region", figure_4_2},
    {"4.3", "Voronoi region of a triangle of the pyramid", figure_4_3},
    {"4.4", "Voronoi region of an edge of the pyramid", figure_4_4},
    {"4.5", "Voronoi region of a vertex of the pyramid", figure_4_5},
    {"4.6", "Voronoi regions of convex bodies", figure_4_6},
    {"4.7", "An unbounded Minkowski sum in the plane", figure_4_7},
    {"4.8", "Copies of the cell at all corners of Voronoi regions", figure_4_8},
    {"4.9", "Sums of cut Voronoi regions", figure_4_9},
    {"5.2", "The closest feature of a haptic cursor", figure_5_2},
    {"5.3", "Lengths of the lists of outer cells", figure_5_3},
    {"5.4", "Two spheres that intersect", figure_5_4},
    {"5.5", "Cells along a ray, all of full weight", figure_5_5},
    {"5.6", "Cells along a ray by their weights", figure_5_6},
    {"5.7", "Culling by a view volume, isometric view", figure_5_7},
    {"5.8", "Culling by a view volume, views along the axes", figure_5_8},
});

constexpr auto absent_figures = std::to_array<MissingFigure>({
    {"2.1", "BSP tree of a scene", "Cited from another work, of a tree that is not built here."},
    {"2.2", "Balanced and optimal BSP trees",
     "Cited from another work, of trees that are not built here."},
    {"5.1", "The haptic device", "A photograph."},
});

} // namespace

Result<FigureContent> make_figure(const ThesisFigure& figure, const Execution& context,
                                  const std::string& models)
{
    return figure.make != nullptr ? figure.make(context) : figure.make_of_models(context, models);
}

std::span<const ThesisFigure> thesis_figures()
{
    return made_figures;
}

std::span<const MissingFigure> missing_figures()
{
    return absent_figures;
}

} // namespace proxima
