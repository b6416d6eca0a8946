// Leaves of octrees as shapes: edges that neighbours share once, and the slice that a plane cuts.
#pragma once

#include "octree/leaf_boxes.h"
#include "proxima/octree.h"
#include "viewer/scene_shapes.h"

#include <span>
#include <vector>

namespace proxima {

/// Blue over green and yellow to red, for 0 to 1; beyond as the ends.
[[nodiscard]] Color ramp_color(double part);

/// Strong enough for lines.
[[nodiscard]] Color class_color(CellClass type);

/// The edges of leaves, each once where leaves of one size share it. \pre of the octree
void add_leaf_edges(DrawnScene& scene, const Octree& octree, std::span<const LeafBox> leaves,
                    const EdgeStyle& style);

/// A plane across an axis.
struct AxisPlane {
    int axis = 0;
    double at = 0.0;
};

/// The square that the plane cuts from a leaf: from the upper one of two that it lies between. A
/// plane at the root's ends, or beyond them by rounding, cuts the leaves there. Empty where it cuts
/// nothing.
[[nodiscard]] Box slice_of(const Octree& octree, const LeafBox& leaf, const AxisPlane& plane);

/// A flat rectangle: a box without extent along one axis.
void add_slices(DrawnScene& scene, std::span<const Box> slices, int axis, const ShapeStyle& style);

} // namespace proxima
