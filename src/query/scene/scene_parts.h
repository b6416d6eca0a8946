// What a scene holds: instances in the order of a tree over their boxes.
//
//     tree     the blocks of a mesh index of segments, for each instance the diagonal of its box: the
//              octree's cells, boxes eight at a time, walked as those of meshes. Its leaves name rows
//              of the scene; it has no triangles (scene_tree.h)
//     rows     by row of the tree, then instances of empty indexes: the box, whose instance it is
//     poses    by row
//     row_of   by instance
//     boxes    by block of the tree, as they are before nodes round them, and the way up: for moves of
//              few instances
//
// Boxes hold the instance as every query has it. Let R, t be a pose, |R^T R - 1| = f at most 1e-9, p a
// point of the shape with |p|_1 <= P, u = 2^-53. As triangles of b in a pair, p is at R p + t. As the
// target of rays and points, moved by R^T, and as a in a pair, it is where R^T takes back to p:
// at R^-T p + t, off by up to 1.01 f P. Rounding moves it further:
//     a point or the origin of a ray, q, moved back      8 u (|q| + |t|); 8 u |q| is the query's part
//     a ray's direction d, at its point o + s d           4 u |s d|, |s d| at most |o| + |t| + P
//     relative_pose: R_a^T R_b 8 u P_b, R_a^T (t_b - t_a) and the moved corner 30 u (P_b + |t_a| + |t_b|)
// The ball of a shape, |p - c| at most 2 P, is turned with it to within f P. All of it is less than
// 4 f P + 2^-46 (|t| + P), by which boxes are drawn out, and 2^-46 |q| (2^-46 |o|),
// by which queries are.
#pragma once

#include "index/binary_tree.h"
#include "index/index_parts.h"
#include "proxima/geometry.h"
#include "proxima/scene.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace proxima {

/// Roundoff of queries in units of their coordinates.
inline constexpr double scene_roundoff = 0x1p-46;

/// The tree's boxes are this much larger than rows' boxes, in units of the tree: so much may rounding move a
/// ray whose walk is in floats.
inline constexpr double scene_tree_margin = 0x1p-23;

/// Eight boxes of a shape's parts, by axis: in lanes, for all are turned for each instance.
struct alignas(64) ShapeBoxes {
    std::array<std::array<double, 8>, 3> center;
    std::array<std::array<double, 8>, 3> half;
};

/// An index as instances share it.
struct InstancedShape {
    MeshIndex index;
    /// All triangles are in one of them; none of an empty index. The last one is there as often as fills an eight.
    std::vector<ShapeBoxes> boxes;
    double reach = 0;           ///< P
    Vec3 center = Vec3::Zero(); ///< of a ball about all corners
    double radius = 0;
};

/// A row of the tree: an instance's box, and what walks ask before they enter it.
struct alignas(64) SceneRow {
    Box box; ///< empty for instances of empty indexes
    std::uint32_t layers = 0;
    std::uint32_t instance = 0;
    std::uint32_t shape = 0;
    std::uint32_t leaf = 0; ///< the block of the tree
};
static_assert(sizeof(SceneRow) == 64);

/// What is kept of a block of the tree, so that it can be drawn again alone.
struct SceneBlock {
    FloatBox box;             ///< of all rows below, in the tree's units
    std::uint32_t parent = 0; ///< 0 for the root's
};

struct PROXIMA_HIDDEN SceneParts {
    std::shared_ptr<const std::vector<InstancedShape>> shapes;
    std::shared_ptr<const std::vector<std::uint32_t>> row_of;
    MeshIndex tree;
    std::span<IndexBlock> blocks;        ///< the tree's own
    std::shared_ptr<const void> storage; ///< of the blocks
    std::vector<SceneBlock> boxes;
    Box all; ///< the tree's frame is about it
    std::vector<SceneRow> rows;
    std::vector<RigidTransform> poses; ///< by row
    double largest_extent = 0; ///< at least twice the longest edge of a box: no diagonal is longer
    double reach = 0;          ///< no coordinate of a box is larger

    [[nodiscard]] const MeshIndex& index(const SceneRow& row) const noexcept
    {
        return (*shapes)[row.shape].index;
    }
    /// Rows of the tree; those behind have empty boxes.
    [[nodiscard]] std::uint32_t tree_rows() const noexcept { return tree.triangle_count(); }
};

} // namespace proxima
