// The quadtree's sums against distances of squares and sets.
#include "viewer/figures/quadtree.h"

#include "viewer/figures/octree_figures.h"
#include "viewer/figures/voronoi_figures.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace proxima::quadtree_test {
namespace {

/// Whether a segment and a closed square have a point in common, by cutting the segment to the
/// square's two slabs.
bool segment_meets(const Vec2& from, const Vec2& to, const QuadtreeLeaf& cell)
{
    double first = 0.0;
    double last = 1.0;
    for (int axis = 0; axis < 2; ++axis) {
        const double start = from[axis] - cell.center[axis];
        const double step = to[axis] - from[axis];
        if (step == 0.0) {
            if (std::abs(start) > cell.half) return false;
            continue;
        }
        const double one = (-cell.half - start) / step;
        const double other = (cell.half - start) / step;
        first = std::max(first, std::min(one, other));
        last = std::min(last, std::max(one, other));
    }
    return first <= last;
}

double area(const std::vector<QuadtreeLeaf>& leaves)
{
    double sum = 0.0;
    for (const QuadtreeLeaf& leaf : leaves) sum += 4.0 * leaf.half * leaf.half;
    return sum;
}

TEST(Quadtree, LeavesListTheSegmentsThatMeetThem)
{
    for (const Subdivision subdivision : {Subdivision::uniform, Subdivision::adaptive}) {
        const auto tree = circle_quadtree(5, subdivision);
        ASSERT_TRUE(tree);
        EXPECT_DOUBLE_EQ(area(tree->leaves), 4.0);
        const auto corners = tree->curve.points();
        for (const QuadtreeLeaf& leaf : tree->leaves) {
            std::vector<int> expected;
            for (std::size_t i = 0; i < corners.size(); ++i) {
                if (segment_meets(corners[i], corners[(i + 1) % corners.size()], leaf))
                    expected.push_back(static_cast<int>(i));
            }
            EXPECT_EQ(leaf.sets, expected);
            const bool is_deepest = leaf.depth == tree->depth;
            EXPECT_TRUE(is_deepest || (subdivision == Subdivision::adaptive && expected.empty()));
        }
        if (subdivision == Subdivision::uniform) {
            EXPECT_EQ(tree->leaves.size(), 1024U);
        }
    }
}

TEST(Quadtree, LeavesOfTheProximityQuadtreeListTheClosestFeatures)
{
    const auto tree = proximity_quadtree();
    ASSERT_TRUE(tree);
    EXPECT_DOUBLE_EQ(area(tree->leaves), 4.0);
    const auto corners = tree->polygon.points();
    const int count = static_cast<int>(corners.size());
    std::mt19937_64 random(41);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    std::size_t points_outside = 0;
    for (const QuadtreeLeaf& leaf : tree->leaves) {
        std::vector<int> seen;
        for (int i = 0; i < 400; ++i) {
            const Vec2 point = leaf.center + leaf.half * Vec2{part(random), part(random)};
            if (is_inside(tree->polygon, point)) continue;
            ++points_outside;
            // Closest of all edges; at an end of one it is a corner.
            int closest = -1;
            double least = 1e9;
            for (int e = 0; e < count; ++e) {
                const Vec2& from = corners[static_cast<std::size_t>(e)];
                const Vec2 along = corners[static_cast<std::size_t>((e + 1) % count)] - from;
                const double t = (point - from).dot(along) / along.squaredNorm();
                const double distance = (from + std::clamp(t, 0.0, 1.0) * along - point).norm();
                if (distance >= least) continue;
                least = distance;
                closest = t <= 0.0 ? e : t >= 1.0 ? (e + 1) % count : count + e;
            }
            seen.push_back(closest);
        }
        std::ranges::sort(seen);
        seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
        // Random points find no more than the list has, and where it has one, just that.
        EXPECT_TRUE(std::ranges::includes(leaf.sets, seen));
        if (leaf.sets.size() == 1 && !seen.empty()) {
            EXPECT_EQ(seen, leaf.sets);
        }
        EXPECT_TRUE(leaf.depth == 4 || leaf.sets.size() <= 1);
    }
    EXPECT_GT(points_outside, 20000U);
}

} // namespace
} // namespace proxima::quadtree_test
