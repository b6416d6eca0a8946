// The binary tree behind a mesh index: the octree's cells, refined until each holds one triangle's
// centre, without those that have a single child; and which of its nodes are best made leaves.
//
//     order   triangles along the Morton curve of the octree's cells, by their centres
//     node    a run of the order, cut where its highest differing bit changes: one of a cell's
//             three halvings; runs at the same position are cut in the middle
//
// A node's cost is the sum of areas of all boxes that it makes queries look into, by dynamic
// programming: cost(node, k) covers it by at most k boxes of one wide node [ylitie-2017].
#pragma once

#include "base/grow_buffer.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

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

/// Where the scale is this one, the mesh may be larger than the frame's [-1, 1].
inline constexpr double least_index_scale = 0x1p-1000;

/// The frame of a mesh of that box; `has_floats`: all its coordinates are.
[[nodiscard]] IndexFrame index_frame(const Box& box, bool has_floats) noexcept;

/// A run of two or more triangles of the order.
struct BinaryNode {
    std::uint32_t left_count; ///< the left child is the next node, if it has two or more
    std::uint32_t choices;    ///< how it is best covered, see BinaryTree
    FloatBox box;
};

struct BinaryTree {
    IndexFrame frame;
    std::vector<TriangleId> order;
    GrowBuffer<FloatBox> boxes;   ///< of the order's triangles
    GrowBuffer<BinaryNode> nodes; ///< parents before children, left before right; root first

    /// A run of the order: the node of two or more triangles, or a single triangle.
    struct Child {
        std::uint32_t node = 0; ///< meaningless for single triangles
        std::uint32_t first = 0;
        std::uint32_t count = 0;
    };
    [[nodiscard]] Child root() const noexcept
    {
        return {0, 0, static_cast<std::uint32_t>(order.size())};
    }
    /// \pre at.count > 1
    [[nodiscard]] std::array<Child, 2> children(const Child& at) const noexcept
    {
        const std::uint32_t left = nodes[at.node].left_count;
        // A run of n triangles has n - 1 nodes.
        return {
            {{at.node + 1, at.first, left}, {at.node + left, at.first + left, at.count - left}}};
    }
    [[nodiscard]] const FloatBox& box(const Child& child) const noexcept
    {
        return child.count == 1 ? boxes[child.first] : nodes[child.node].box;
    }

    // Choices: three bits for each number of boxes from 2 up say how many the left child gets; then
    // a bit for each says that one box does as well; the highest bit is set for leaves.
    static constexpr std::uint32_t leaf_choice = 1U << 31U;
    [[nodiscard]] static constexpr unsigned share_bit(std::uint32_t most) noexcept
    {
        return 3 * (most - 2);
    }
    [[nodiscard]] static constexpr unsigned single_bit(std::uint32_t most) noexcept
    {
        return 3 * (index_width - 1) + most - 2;
    }

    /// Whether it is better a leaf than a node.
    [[nodiscard]] bool is_leaf(const Child& child) const noexcept
    {
        return child.count == 1 || (nodes[child.node].choices & leaf_choice) != 0;
    }
    /// Whether one box covers it as cheaply as `most`. \pre most in [1, index_width]
    [[nodiscard]] bool is_single(const Child& child, std::uint32_t most) const noexcept
    {
        return most == 1 || child.count == 1 ||
               (nodes[child.node].choices >> single_bit(most) & 1U) != 0;
    }
    /// How many of `most` boxes the left child gets where a node is not covered by one; the right
    /// child gets the rest. \pre most in [2, index_width]
    [[nodiscard]] std::uint32_t left_share(std::uint32_t node, std::uint32_t most) const noexcept
    {
        return nodes[node].choices >> share_bit(most) & 7U;
    }
};

/// Error cancelled. The same for any number of threads. O(triangles log triangles).
/// \pre the mesh has triangles and lies in `root`, `frame` is that of a box that contains it
[[nodiscard]] Result<BinaryTree> build_binary_tree(const TriangleMesh& mesh,
                                                   const IndexFrame& frame, const OctreeFrame& root,
                                                   Threads threads, Progress* progress);

} // namespace proxima
