// Figures of thesis chapter 2 and 3.16: quadtrees and octrees.
#pragma once

#include "proxima/execution.h"
#include "viewer/figures/quadtree.h"
#include "viewer/figures/thesis_figure.h"

namespace proxima {

/// What figures 2.3 and 2.4 show of one depth: a closed curve of straight edges and its cells.
struct CurveQuadtree {
    ConvexPolygon curve;
    std::vector<QuadtreeLeaf> leaves; ///< sets number the curve's edges
    int depth = 0;

    /// Of a leaf: boundary where it meets the curve.
    [[nodiscard]] CellClass type(const QuadtreeLeaf& leaf) const;
};

/// The quadtree of a circle of 96 edges.
[[nodiscard]] Result<CurveQuadtree> circle_quadtree(int depth, Subdivision subdivision);

[[nodiscard]] Result<FigureContent> figure_2_3(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_2_4(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_2_5(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_2_6(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_2_7(const Execution& context, const std::string& folder);
[[nodiscard]] Result<FigureContent> figure_3_16(const Execution& context);

} // namespace proxima
