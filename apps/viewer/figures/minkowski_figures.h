// Figures of thesis chapter 3: Minkowski sums in the plane and in space.
#pragma once

#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "thesis/minkowski_sums/planar_sum.h"
#include "viewer/figures/thesis_figure.h"

#include <array>

namespace proxima {

/// The sum that figures 3.1 to 3.6 explain, and 3.14 at two sizes: A a rectangle around the
/// origin, the pivot, B a triangle. Points v0 to v11, lines n1 to n3 the triangle's, n4 to n7 the
/// rectangle's.
[[nodiscard]] Result<PlanarSum> explained_planar_sum();

/// The two outermost of the points that a line rests on, in the direction of the edge.
/// \pre it spans an edge
[[nodiscard]] std::array<int, 2> end_points(const PlanarSum& sum, const PushedLine& line);

/// The sum of figures 3.7 to 3.11: A a cube, B an octahedron.
[[nodiscard]] Result<MinkowskiSum> explained_sum();

[[nodiscard]] Result<FigureContent> figure_3_1(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_2(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_3(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_4(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_5(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_6(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_7(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_8(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_9(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_10(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_11(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_12(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_13(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_14(const Execution& context);
[[nodiscard]] Result<FigureContent> figure_3_15(const Execution& context);

} // namespace proxima
