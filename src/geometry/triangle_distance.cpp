#include "geometry/triangle_distance.h"

#include "geometry/triangle_intersection.h"

#include <algorithm>
#include <cmath>
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
        for (const Vec3& p : first.vertices) {
            for (const Vec3& q : second.vertices)
                reach_ = std::max(reach_, (q - p).cwiseAbs().maxCoeff());
        }
    }

    /// Tries each corner against the other triangle.
    void try_corners() noexcept
    {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& p = first_.vertices[i];
            const Vec3& q = second_.vertices[i];
            offer(closest_point(first_, q), point_of_side(i, {q, 0}));
            offer(point_of_side(i, {p, 0}), closest_point(second_, p));
        }
    }

    /// Tries each pair of sides.
    void try_sides() noexcept
    {
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const SegmentPair pair = closest_points(side_of(first_, i), side_of(second_, k));
                offer(point_of_side(i, pair.first), point_of_side(k, pair.second));
            }
        }
    }

    /// Whether all corners lie behind the planes through the closest points, across the line
    /// between them, up to a few roundings. Then no pair is nearer by more than these.
    [[nodiscard]] bool surely_closest() const noexcept
    {
        const Vec3 gap = best_.second.point - best_.first.point;
        const double length = std::sqrt(best_.squared_distance);
        double beyond = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            beyond = std::max({beyond, gap.dot(first_.vertices[i] - best_.first.point),
                               gap.dot(best_.second.point - second_.vertices[i])});
        }
        return length > 0x1p-40 * reach_ && beyond <= 0x1p-53 * reach_ * length;
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

    [[nodiscard]] ClosestTrianglePoints& best() noexcept { return best_; }

    /// The least squared distance that differs from zero.
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
    ClosestTrianglePoints best_;
};

} // namespace

ClosestTrianglePoints closest_points(const Triangle& first, const Triangle& second) noexcept
{
    ClosestPair search(first, second);
    search.try_corners();
    if (search.surely_closest()) return search.best();
    search.try_sides();
    ClosestTrianglePoints& best = search.best();
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
