// Grows the part of an octree below one cell, level by level, with any child test.
#pragma once

#include "octree/distribute_children.h"
#include "octree/snapped_mesh.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

namespace proxima {

/// One cell and the triangles that touch it, ascending.
struct Subtree {
    GridPoint lower = {}; ///< in grid steps
    int depth = 0;
    std::span<const std::uint32_t> triangles;
};

/// Decides which children triangles touch; one object serves one thread at a time.
class ChildTest {
public:
    virtual ~ChildTest() = default;
    ChildTest(const ChildTest&) = delete;
    ChildTest& operator=(const ChildTest&) = delete;

    /// The following levels are of this subtree.
    virtual void begin(const Subtree& subtree) = 0;

    /// masks[pair] for every pair of the level, whose cells are at `depth`. May stop early when
    /// work is cancelled.
    virtual void find_touched(const SplitLevel& level, int depth, std::uint32_t* masks) = 0;

protected:
    ChildTest() = default;
};

/// What growing obeys, shared by all threads.
struct GrowLimits {
    int max_depth = 0;
    std::uint32_t threshold = 0;
    std::uint64_t budget_bytes = 0;
    Progress* progress = nullptr;
    std::atomic<std::uint64_t> used_bytes{0}; ///< of all outputs and scratch together
};

/// Reusable scratch of one thread.
class SubtreeGrower {
public:
    explicit SubtreeGrower(GrowLimits& limits) noexcept : limits_(limits) {}

    /// Appends the subtree to the output and returns its own node; offsets are the output's.
    /// Errors: budget_exceeded, limit_exceeded, cancelled; the output is then worthless.
    [[nodiscard]] Result<OctreeNode> grow(const Subtree& subtree, ChildTest& test,
                                          OctreeOutput& output);

    /// Pairs of a triangle and a cell that were split so far.
    [[nodiscard]] std::uint64_t split_pairs() const noexcept { return split_pairs_; }

private:
    [[nodiscard]] Status reserve(std::uint64_t children, const OctreeOutput& output);

    GrowLimits& limits_;
    SplitLevel level_;
    SplitLevel next_;
    GrowBuffer<std::uint32_t> masks_;
    std::uint64_t counted_bytes_ = 0;
    std::uint64_t split_pairs_ = 0;
};

} // namespace proxima
