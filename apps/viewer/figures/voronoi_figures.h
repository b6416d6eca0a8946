// Figures of thesis chapter 4 and 5.3: Voronoi regions and proximity octrees.
#pragma once

#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"
#include "viewer/figures/quadtree.h"
#include "viewer/figures/thesis_figure.h"

#include <vector>

namespace proxima {

/// Figure 4.1: a polygon and the quadtree of its exterior Voronoi regions: sets are its corners,
/// then its edges.
struct ProximityQuadtree {
    ConvexPolygon polygon;
    std::vector<QuadtreeLeaf> leaves;
    double half = 0.0; ///< of the root, around the origin
};
[[nodiscard]] Result<ProximityQuadtree> proximity_quadtree();

/// Figure 4.2: a sphere, its proximity octree, and the outer leaves that list one feature.
struct ListedFeature {
    TriangleMesh mesh;
    ThesisProximityOctree octree;
    Feature feature;
    std::vector<ThesisCell> outer;   ///< all outer leaves
    std::vector<ThesisCell> listing; ///< those of them that list the feature
};
[[nodiscard]] Result<ListedFeature> sphere_with_listed_feature(const Execution& context);

/// The square pyramid of figures 4.3 to 4.5, 4.8 and 4.9.
[[nodiscard]] TriangleMesh make_pyramid();

[[nodiscard]] Result<FigureContent> figure_4_1(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_2(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_3(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_4(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_5(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_6(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_7(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_8(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_4_9(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_5_3(const Execution& context);

} // namespace proxima
