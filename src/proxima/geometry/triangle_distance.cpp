#include "proxima/geometry/triangle_distance.h"

#include "proxima/geometry/triangle_intersection.h"

#include <algorithm>
#include <limits>

namespace proxima {
namespace {

Segment side_of(const Triangle& triangle, std::size_t i) noexcept
{
    return {triangle.vertices[i], triangle.vertices[(i + 1) % 3]};
}

/// The closest pair so far.
class ClosestPair {
public:
    ClosestPair(const Triangle& first, const Triangle& second) noexcept
        : first_(first), second_(second)
    {
        for (const Vec3& p : first.vertices)
            for (const Vec3& q : second.vertices)
                reach_ = std::max(reach_, (q - p).cwiseAbs().maxCoeff());
    }

    /// All that can be closest while the triangles are apart.
    void try_features() noexcept
    {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto on_first = closest_point_inside(first_, second_.vertices[i]);
            if (on_first) offer(*on_first, point_of_side(i, {second_.vertices[i], 0}));
            const auto on_second = closest_point_inside(second_, first_.vertices[i]);
            if (on_second) offer(point_of_side(i, {first_.vertices[i], 0}), *on_second);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const SegmentPair pair = closest_points(side_of(first_, i), side_of(second_, k));
                offer(point_of_side(i, pair.first), point_of_side(k, pair.second));
            }
        }
    }

    /// Whether a plane across the line between the closest points surely separates the triangles.
    [[nodiscard]] bool surely_apart() const noexcept
    {
        const Vec3 gap = best_.second.point - best_.first.point;
        // From one point, so that rounding is that of differences: sums of three products of
        // numbers below reach, each off by less than 8 roundings.
        const Vec3& from = first_.vertices[0];
        double first_far = 0;
        double second_near = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            first_far = std::max(first_far, gap.dot(first_.vertices[i] - from));
            second_near = std::min(second_near, gap.dot(second_.vertices[i] - from));
        }
        return second_near - first_far > 0x1p-48 * reach_ * gap.cwiseAbs().sum() + tiny;
    }

    [[nodiscard]] TrianglePair& best() noexcept { return best_; }

    /// The least squared distance that is told from none.
    static constexpr double tiny = std::numeric_limits<double>::min();

private:
    void offer(const TrianglePoint& on_first, const TrianglePoint& on_second) noexcept
    {
        const double squared = (on_first.point - on_second.point).squaredNorm();
        if (!(squared < best_.squared_distance)) return;
        best_ = {on_first, on_second, squared};
    }

    const Triangle& first_;
    const Triangle& second_;
    double reach_ = 0; ///< largest difference of coordinates of a corner of each
    TrianglePair best_;
};

} // namespace

TrianglePair closest_points(const Triangle& first, const Triangle& second) noexcept
{
    ClosestPair search(first, second);
    search.try_features();
    TrianglePair& best = search.best();
    if (search.surely_apart()) return best;
    const TriangleIntersection meeting = intersect(first, second);
    if (meeting.empty()) {
        best.squared_distance = std::max(best.squared_distance, ClosestPair::tiny);
        return best;
    }
    const Vec3 common = meeting_point(first, second, meeting.ends()[0]);
    best = {closest_point(first, common), closest_point(second, common), 0};
    best.first.point = common;
    best.second.point = common;
    return best;
}

} // namespace proxima
