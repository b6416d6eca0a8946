// A tree of planes over the facets of a bounded Minkowski sum, so that a point is told inside or
// outside by few of them (the thesis's future work, 3.6.4).
//
//     bounding box -> split by an axis-parallel plane or by a facet's own -> ... -> leaf
//     leaf: outside, inside, or the facets that meet its cell
//
// Why a leaf needs no others. Let S be the sum, C a closed convex cell, I the facets F_i that meet
// C, and H_i their half-spaces. If I is not empty, a point q of C is in S iff it is in H_i for all
// i in I:
//   - A point of S is in every H_i.
//   - Let q in C be outside S. Some F_i meets C, so a point s of S lies in C, and with it the whole
//     way from s to q. Let x be the last point of S on it. Near x, S is the intersection of the
//     half-spaces of the facets that hold x; just beyond x one of them, H_i, is left, and being a
//     half-space it is not entered again before q. Its facet F_i holds x, a point of C: i is in I.
// If I is empty, C has no boundary of S in it and lies wholly inside or outside. A facet's own
// plane as a split leaves nothing of S in front of it, and its facet need not be asked behind it.
// More facets than I do no harm: pieces of facets are cut a little too large, so that rounding
// loses none.
//
// What it is worth, measured by bench/sum_partition_bench.cpp (evaluations per query: comparisons
// of a coordinate + products with a normal; one thread of one machine, so read the times as
// ratios):
//
//                                       fixed order     free accepts    tree            tree is
//     triangle and child cell, building an octree of
//       a sphere of 19,800, depth 5     3.3 + 1.64      2.8 + 0.14      3.8 + 0.17      1.7x slower
//       a bunny, threshold 8            3.5 + 1.89      3.5 + 0.40      4.0 + 0.32      1.8x slower
//     the same sums, uniform points     6.0 + 9.5       -               8.7 + 1.1       1.9x slower
//     two polytopes of 1,000 vertices   6.0 + 3458      -               13.4 + 1.3      78x faster
//
// So for a triangle and a cube the tree does what the thesis hoped, a sixth to a tenth of the
// products, and still does not pay: most questions end at the bounding box, a product of two terms
// costs less than a step down a tree whose branch cannot be predicted, and a tree that takes 0.4 ms
// to build is asked eleven questions before the next size of cube needs another. Free accepts
// (triangle_cube_descent.h) save as many products with nothing built. For the 6,558 facets of the
// large sum a tree of 0.2 s is paid back after 28,000 questions.
#pragma once

#include "proxima/geometry.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// What a query did.
struct PartitionEvaluations {
    std::int64_t comparisons = 0;  ///< of one coordinate with an axis-parallel plane
    std::int64_t dot_products = 0; ///< of the point with a plane's normal

    [[nodiscard]] std::int64_t total() const noexcept { return comparisons + dot_products; }
};

struct PartitionOptions {
    int max_depth = 48; ///< of splits; 0: only the bounding box and one leaf
    /// A split must save as many evaluations per query, on average over the bounding box.
    double min_saving = 1e-4;
};

/// Immutable. Members do not allocate and may be called from any thread.
class SumPartition {
public:
    /// Whether the closed sum holds the point; within 1e-14 of the sum's size of its boundary,
    /// rounding decides.
    [[nodiscard]] bool contains(const Vec3& point) const noexcept;

    /// The same, adding up what it cost.
    [[nodiscard]] bool contains(const Vec3& point,
                                PartitionEvaluations& evaluations) const noexcept;

    [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }
    /// Facets of the sum, those on its bounding box included.
    [[nodiscard]] std::size_t facet_count() const noexcept { return planes_.size(); }
    [[nodiscard]] std::size_t split_count() const noexcept { return splits_.size(); }
    /// Leaves that hold facets; the others are only inside or outside.
    [[nodiscard]] std::size_t leaf_count() const noexcept { return leaves_.size(); }
    /// Facets in all leaves together.
    [[nodiscard]] std::size_t reference_count() const noexcept { return references_.size(); }
    [[nodiscard]] int depth() const noexcept { return depth_; }

private:
    friend class PartitionBuilder;

    /// A child: a split's index, or what a leaf is.
    using Child = std::int32_t;
    static constexpr Child outside = -1;
    static constexpr Child inside = -2;
    static constexpr Child first_leaf = -3; ///< leaf i is first_leaf - i

    struct Split {
        HalfSpace plane;
        std::int32_t axis = -1; ///< 0 to 2 if the plane is axis-parallel
        Child within = outside; ///< normal . x <= offset
        Child beyond = outside;
    };
    struct Leaf {
        std::uint32_t first = 0;
        std::uint32_t count = 0;
    };

    template <class Count>
    [[nodiscard]] bool find(const Vec3& point, Count count) const noexcept;

    Box bounds_;
    Child root_ = outside;
    int depth_ = 0;
    std::vector<HalfSpace> planes_;
    std::vector<Split> splits_;
    std::vector<Leaf> leaves_;
    std::vector<std::uint32_t> references_;
};

/// Builds a tree for points spread evenly over the sum's bounding box: each split is the one of
/// some dozens, axis-parallel or facets' own, that promises the fewest evaluations, and is taken if
/// it promises fewer than a leaf. O(n log n) for n facets of a round sum.
/// Errors: invalid_argument (the sum is unbounded or flat).
[[nodiscard]] Result<SumPartition> partition_sum(const MinkowskiSum& sum,
                                                 const PartitionOptions& options = {});

} // namespace proxima
