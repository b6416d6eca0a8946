// Builds with any of the thesis's overlap tests: the same level-by-level growth, one test object a
// triangle, re-prepared for each depth (thesis 3.4: the sum is made once per triangle and depth).
#pragma once

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/triangle_box.h"
#include "octree/grow_subtree.h"
#include "proxima/octree.h"
#include "proxima/thesis.h"
#include "thesis/octree_generation/overlap_tests.h"

#include <numeric>
#include <vector>

namespace proxima {

/// Tests every child of every pair by itself, in parallel over cells.
template <OverlapTest Test>
class EachChildTest final : public ChildTest {
public:
    /// Not to be used once work is cancelled.
    template <class Make>
    EachChildTest(const TriangleMesh& mesh, const OctreeFrame& frame, const OctreeOptions& options,
                  Exactness exactness, const Make& make)
        : mesh_(mesh), frame_(frame), options_(options), exactness_(exactness)
    {
        tests_.reserve(mesh.triangle_count());
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            if (id % 1024 == 0 && is_cancelled(options.execution.progress)) return;
            tests_.push_back(make(mesh.triangle(TriangleId{id})));
        }
    }

    void begin(const Subtree&) override {}

    void find_touched(const SplitLevel& level, int depth, std::uint32_t* masks) override
    {
        prepare(level, depth + 1);
        begin_stage(options_.execution.progress, "octree level", level.cells.size());
        constexpr std::size_t chunk = 64;
        // Few cells of many pairs at the top, many of few below: chunks of both.
        parallel_chunks(level.cells.size(), chunk, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            for (std::size_t cell = first; cell < end; ++cell) {
                                if (is_cancelled(options_.execution.progress)) return;
                                test_cell(level, level.cells[cell], depth, masks);
                                advance_stage(options_.execution.progress, 1);
                            }
                        });
    }

private:
    /// Brings the tests of all triangles in the level to the depth of the children.
    void prepare(const SplitLevel& level, int child_depth)
    {
        std::vector<char> is_used(tests_.size(), 0);
        for (std::size_t pair = 0; pair < level.pair_count; ++pair) {
            is_used[level.triangle[pair]] = 1;
        }
        const Vec3 half = frame_.edge / static_cast<double>(std::uint64_t{2} << child_depth);
        constexpr std::size_t chunk = 256;
        parallel_chunks(tests_.size(), chunk, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(options_.execution.progress)) return;
                            for (std::size_t id = first; id < end; ++id) {
                                if (is_used[id] != 0) tests_[id].set_half_size(half);
                            }
                        });
    }

    void test_cell(const SplitLevel& level, const SplitCell& cell, int depth,
                   std::uint32_t* masks) const
    {
        std::array<Box, 8> boxes;
        std::array<Vec3, 8> centers;
        for (unsigned child = 0; child < 8; ++child) {
            boxes[child] = child_box(cell, child, depth);
            centers[child] = boxes[child].center();
        }
        for (std::uint32_t pair = cell.first; pair < cell.first + cell.count; ++pair) {
            if (pair % 1024 == 0 && is_cancelled(options_.execution.progress)) return;
            const std::uint32_t id = level.triangle[pair];
            std::uint32_t mask = 0;
            for (unsigned child = 0; child < 8; ++child) {
                Overlap overlap = tests_[id].overlap(centers[child]);
                if (!overlap.certain && exactness_ == Exactness::exact) {
                    overlap.overlaps =
                        triangle_overlaps_box(mesh_.triangle(TriangleId{id}), boxes[child]);
                }
                if (overlap.overlaps) mask |= 1U << child;
            }
            masks[pair] = mask != 0 ? mask : rescue(id, boxes);
        }
    }

    /// Rounding may keep a triangle in a cell and in none of its children. It is not lost: it goes
    /// to the children that it touches exactly, or, if the cell should not have had it, to the one
    /// on its centroid's side.
    [[nodiscard]] std::uint32_t rescue(std::uint32_t id, const std::array<Box, 8>& children) const
    {
        const Triangle triangle = mesh_.triangle(TriangleId{id});
        std::uint32_t touched = 0;
        for (unsigned child = 0; child < 8; ++child) {
            if (triangle_overlaps_box(triangle, children[child])) touched |= 1U << child;
        }
        if (touched != 0) return touched;
        const Vec3 centroid = triangle[0] / 3 + triangle[1] / 3 + triangle[2] / 3;
        unsigned nearest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (centroid[axis] > children[0].upper[axis]) nearest |= 1U << axis;
        }
        return 1U << nearest;
    }

    [[nodiscard]] Box child_box(const SplitCell& cell, unsigned child, int depth) const
    {
        const int shift = snapped_bits - depth - 1;
        Box box;
        for (int axis = 0; axis < 3; ++axis) {
            const std::int32_t middle = cell.center[static_cast<std::size_t>(axis)] >> shift;
            const bool upper = (child >> axis & 1U) != 0;
            const auto index = static_cast<std::uint32_t>(upper ? middle : middle - 1);
            box.lower[axis] = frame_.plane(axis, index, depth + 1);
            box.upper[axis] = frame_.plane(axis, index + 1, depth + 1);
        }
        return box;
    }

    const TriangleMesh& mesh_;
    const OctreeFrame& frame_;
    const OctreeOptions& options_;
    Exactness exactness_;
    std::vector<Test> tests_;
};

/// Nodes and references of the octree, found with Test. In exact mode, where the test's rounding
/// could matter, the exact predicate decides. `make` makes the test of a triangle.
template <OverlapTest Test, class Make>
[[nodiscard]] Result<OctreeOutput>
build_with_test(const TriangleMesh& mesh, const OctreeFrame& frame, const OctreeOptions& options,
                Exactness exactness, GrowLimits& limits, const Make& make)
{
    limits.used_bytes += mesh.triangle_count() * sizeof(Test);
    if (auto status = check_budget({limits.budget_bytes}, limits.used_bytes, "the overlap test",
                                   "choose the fast method or raise the budget");
        !status) {
        return tl::unexpected(status.error());
    }
    std::vector<std::uint32_t> ids(mesh.triangle_count());
    std::iota(ids.begin(), ids.end(), 0U);
    EachChildTest<Test> test(mesh, frame, options, exactness, make);
    if (is_cancelled(options.execution.progress)) return cancelled("building the octree");
    OctreeOutput output;
    // The root's own node comes first; its descendants follow breadth first.
    output.nodes.push_back(OctreeNode{});
    const auto root = SubtreeGrower(limits).grow({{}, 0, ids}, test, output);
    if (!root) return tl::unexpected(root.error());
    output.nodes[0] = *root;
    output.nodes.shrink_to_fit();
    output.references.shrink_to_fit();
    return output;
}

} // namespace proxima
