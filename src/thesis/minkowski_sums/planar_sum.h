// The Minkowski sum of two convex polygons by the thesis's geometric method, in the plane where it
// explains it (thesis 3.2, Figures 3.1 to 3.6 and 3.14; unbounded ones 4.3.3, Figure 4.7).
//
//     A 4 corners, B 3     points  v_k = a_i + b_j, k = i + |A| j            12
//                          lines   of B's edges, then of A's, each pushed     7
//                                  along its outward normal to the farthest points
//                          edges   where lines rest on two points or more     7
//
//     unbounded operands   rays are cut at a length, the sum of what is left is taken, and edges
//                          with a positive product with a ray, which obstruct it, are removed
//
// The lines are pushed by the code that pushes planes in space (geometric_method.h); every step is
// kept, so that it can be shown. Which points an edge joins is exact for the doubles given: among
// the points that rounding cannot tell apart, signs of exact determinants decide. Positions and
// offsets are rounded. So the edges, their order and their indices depend neither on rounding nor
// on where rays are cut.
#pragma once

#include "minkowski/convex_polygon.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

#include <span>
#include <vector>

namespace proxima {

/// A corner of A and one of B, their sum a point of the sum.
struct CornerPair {
    int a = 0; ///< i
    int b = 0; ///< j
    friend bool operator==(const CornerPair&, const CornerPair&) = default;
};

/// Sizes of the operands: index tracking (thesis 3.5) finds the sum's corners at any.
struct PlanarScales {
    double a = 1;
    double b = 1;
};

/// A line where it came to rest: normal . x <= offset holds the cut sum.
struct PushedLine {
    FacetOrigin origin = FacetOrigin::a; ///< a or b
    int source_edge = 0;                 ///< of the cut polygon A or B
    Vec2 normal;                         ///< outward, of length 1
    double offset = 0;
    int support = 0;         ///< k of the first of the points farthest along the normal
    bool spans_edge = false; ///< it rests on two distinct points or more
    int edge = -1;           ///< the edge of the sum on it, -1 where it is removed as obstructing
    int first_touched = 0;   ///< see PlanarSum::touched
    int touched_count = 0;
};

/// An edge of the sum, walked with the sum to its left.
struct PlanarEdge {
    FacetOrigin origin = FacetOrigin::a; ///< a, b or both, where edges are parallel
    Vec2 normal;                         ///< outward, of length 1
    double offset = 0;
    int support =
        0;        ///< k of the corner pair it rests on at every scale: its end where that is finite
    int from = 0; ///< k where it begins; of an infinite edge the cut's point
    int to = 0;   ///< k where it ends
    bool from_infinity = false;
    bool to_infinity = false;
};

/// Immutable. Members do not allocate and may be called from any thread. Indices must be in range.
class PlanarSum {
public:
    [[nodiscard]] const CutPolygon& a() const noexcept { return a_; }
    [[nodiscard]] const CutPolygon& b() const noexcept { return b_; }

    /// All v_k, inner ones among them: |A| |B|, the cut's corners included.
    [[nodiscard]] std::span<const Vec2> points() const noexcept { return points_; }
    /// i = k mod |A|, j = k div |A|.
    [[nodiscard]] CornerPair pair(int k) const noexcept
    {
        const int size_a = static_cast<int>(a_.corners.size());
        return {k % size_a, k / size_a};
    }
    [[nodiscard]] int index(const CornerPair& pair) const noexcept
    {
        return pair.a + static_cast<int>(a_.corners.size()) * pair.b;
    }
    /// The point of the same index for operands of other sizes.
    [[nodiscard]] Vec2 point(int k, const PlanarScales& scales) const noexcept;

    /// Every line pushed, in order: B's, then A's.
    [[nodiscard]] std::span<const PushedLine> lines() const noexcept { return lines_; }
    /// The points that a line came to rest on, ascending, but for rounding.
    [[nodiscard]] std::span<const int> touched(const PushedLine& line) const noexcept
    {
        return std::span(touched_).subspan(static_cast<std::size_t>(line.first_touched),
                                           static_cast<std::size_t>(line.touched_count));
    }

    /// Edges counter-clockwise: each ends where the next begins. An unbounded sum's first comes
    /// from infinity, a bounded one's has the direction of least angle to the x axis, in [0, 360)
    /// degrees. None of two points, and none where the sum is the whole plane.
    [[nodiscard]] std::span<const PlanarEdge> edges() const noexcept { return edges_; }
    /// An edge's offset for operands of other sizes.
    [[nodiscard]] double offset(const PlanarEdge& edge, const PlanarScales& scales) const noexcept
    {
        return edge.normal.dot(point(edge.support, scales));
    }

    [[nodiscard]] bool is_bounded() const noexcept { return a_.is_bounded() && b_.is_bounded(); }
    [[nodiscard]] bool is_whole_plane() const noexcept { return !is_bounded() && edges_.empty(); }

private:
    friend class PlanarSummation;

    CutPolygon a_;
    CutPolygon b_;
    std::vector<Vec2> points_;
    std::vector<PushedLine> lines_;
    std::vector<int> touched_;
    std::vector<PlanarEdge> edges_;
};

struct PlanarSumOptions {
    double cut_length = 1; ///< where rays are cut, in multiples of the ray given
};

/// The sum A (+) B. Cost |A| |B| (|A| + |B|) products.
/// Errors: invalid_argument (cut length), limit_exceeded (more than 2^22 points).
[[nodiscard]] Result<PlanarSum> planar_sum(const ConvexPolygon& a, const ConvexPolygon& b,
                                           const PlanarSumOptions& options = {});

} // namespace proxima
