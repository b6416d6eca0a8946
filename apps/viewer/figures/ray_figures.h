// Figures of thesis section 5.3: cells along a ray.
#pragma once

#include "proxima/cells_along_ray.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"
#include "viewer/figures/thesis_figure.h"

#include <vector>

namespace proxima {

/// A ray through an octree and the cells that it lights.
struct LitCells {
    TriangleMesh mesh;
    Octree octree;
    Ray ray;
    std::vector<CellOnRay> cells;
};

/// Figure 5.5: a ray along an axis through the middle of every cell of a uniform octree.
[[nodiscard]] Result<LitCells> fully_lit_cells(const Execution& context);
/// Figure 5.6: a slanted ray through an adaptive one.
[[nodiscard]] Result<LitCells> variously_lit_cells(const Execution& context);

[[nodiscard]] Result<FigureContent> figure_5_5(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_5_6(const Execution& context);

} // namespace proxima
