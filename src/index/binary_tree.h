// The binary tree behind a mesh index: the octree's cells, refined until each holds one triangle's
// centre, without those that have a single child; and which of its nodes are best made leaves.
//
//     order   triangles along the Morton curve of the octree's cells, by their centres
//     node    a run of the order, cut where its highest differing bit changes: one of a cell's
//     three
//             halvings; runs of the same place are cut in the middle
//
// A node's cost is the sum of areas of all boxes that it makes rays look into, by dynamic
// programming: cost(node, k) covers it by at most k boxes of one wide node [ylitie-2017].
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "mesh/triangle_mesh.h"
#include "octree/cell.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima {

/// How many triangles, and vertices, a leaf of a mesh index may have, and children a node.
inline constexpr std::uint32_t index_width = 8;

/// A box in units of the mesh's size about its centre, rounded to the nearest floats.
struct FloatBox {
    std::array<float, 3> lower;
    std::array<float, 3> upper;

    [[nodiscard]] float half_area() const noexcept
    {
        const float x = upper[0] - lower[0];
        const float y = upper[1] - lower[1];
        const float z = upper[2] - lower[2];
        return x * y + y * z + z * x;
    }
};

/// Where coordinates of a mesh index count from, and in what.
struct IndexFrame {
    Vec3 center = Vec3::Zero();
    double scale = 1;

    [[nodiscard]] Vec3 to_frame(const Vec3& p) const noexcept { return (p - center) * scale; }
};

/// The frame of a mesh of that box; `has_floats`: all its coordinates are.
[[nodiscard]] IndexFrame index_frame(const Box& box, bool has_floats) noexcept;

/// A run of two or more triangles of the order.
struct BinaryNode {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t left_count = 0; ///< the left child is the next node, if it has two or more
    FloatBox box = {};
    std::array<float, index_width> cost = {}; ///< [k - 1]: covered by at most k
    bool is_leaf = false;                     ///< covered by one: better a leaf than a node
};

struct BinaryTree {
    IndexFrame frame;
    bool has_floats = false; ///< all the mesh's coordinates are
    std::vector<TriangleId> order;
    std::vector<FloatBox> boxes;   ///< of the order's triangles
    std::vector<BinaryNode> nodes; ///< parents before children, left before right; root first

    /// A child of a node: its own place among the nodes, or a single triangle.
    struct Child {
        std::uint32_t node = 0;  ///< meaningless for single triangles
        std::uint32_t first = 0; ///< of the order
        std::uint32_t count = 0;
    };
    [[nodiscard]] Child root() const noexcept;
    [[nodiscard]] std::array<Child, 2> children(std::uint32_t node) const noexcept;
    [[nodiscard]] const FloatBox& box(const Child& child) const noexcept
    {
        return child.count == 1 ? boxes[child.first] : nodes[child.node].box;
    }
    [[nodiscard]] bool is_leaf(const Child& child) const noexcept
    {
        return child.count == 1 || nodes[child.node].is_leaf;
    }
    /// Of being covered by at most `most` boxes. \pre most in [1, index_width]
    [[nodiscard]] float cost(const Child& child, std::uint32_t most) const noexcept;
    /// How many of `most` boxes the left child gets where a node is not covered by one; the right
    /// child gets the rest. \pre most in [2, index_width]
    [[nodiscard]] std::uint32_t left_share(std::uint32_t node, std::uint32_t most) const noexcept;
};

/// Whether a float, not a subnormal one, holds the same number.
[[nodiscard]] bool is_float(double value) noexcept;

/// Error cancelled. The same for any number of threads. O(triangles log triangles).
/// \pre the mesh has triangles, `box` is its box, `root` contains it
[[nodiscard]] Result<BinaryTree> build_binary_tree(const TriangleMesh& mesh, const Box& box,
                                                   const OctreeFrame& root, Threads threads,
                                                   Progress* progress);

} // namespace proxima
