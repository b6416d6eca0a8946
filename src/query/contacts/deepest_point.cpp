#include "query/contacts/deepest_point.h"

#include "base/progress.h"
#include "geometry/length.h"
#include "proxima/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

namespace proxima {

namespace {

/// What a point is in A and B: depths, negative outside.
struct Depths {
    double in_a = 0;
    double in_b = 0;

    [[nodiscard]] bool is_common() const { return in_a >= 0 && in_b >= 0; }
    [[nodiscard]] double sum() const { return in_a + in_b; }
};

/// A box that may hold a better point: no point of it is deeper than `most`.
struct SearchCell {
    double most;
    Vec3 center;
    Vec3 half;
    std::uint32_t number; ///< of equal ones the first

    friend bool operator<(const SearchCell& a, const SearchCell& b)
    {
        return a.most != b.most ? a.most < b.most : a.number > b.number;
    }
};

Box hull_box(const ConvexPolyhedron& hull, const RigidTransform& pose)
{
    Box box;
    for (const Vec3& p : hull.points()) box.extend(pose(p));
    return box;
}

class DeepestSearch {
public:
    DeepestSearch(const SolidParts& a, const SolidParts& b, const RigidTransform& pose_b,
                  std::uint32_t max_points, const Progress* progress)
        : a_(a), b_(b), back_(true_inverse(pose_b)), left_(max_points), progress_(progress)
    {}

    DeepestPoint find(const Box& box)
    {
        add(box.center(), 0.5 * box.extent());
        while (!cells_.empty() && left_ > 0 && !is_cancelled(progress_)) {
            const SearchCell cell = cells_.top();
            cells_.pop();
            constexpr double enough = 1 + 1e-4;
            if (cell.most <= best_.depth * enough) break;
            const Vec3 half = 0.5 * cell.half;
            for (int octant = 0; octant < 8; ++octant) {
                const Vec3 side((octant & 1) != 0 ? 1 : -1, (octant & 2) != 0 ? 1 : -1,
                                (octant & 4) != 0 ? 1 : -1);
                add(cell.center + half.cwiseProduct(side), half);
            }
        }
        climb(1e-2 * box.extent().maxCoeff());
        return best_;
    }

private:
    [[nodiscard]] Depths depths_at(const Vec3& p)
    {
        --left_;
        const auto in_a = signed_distance(a_.index, p);
        const auto in_b = signed_distance(b_.index, back_(p));
        return {in_a ? -in_a->distance : -HUGE_VAL, in_b ? -in_b->distance : -HUGE_VAL};
    }

    bool improve(const Vec3& p)
    {
        const Depths depths = depths_at(p);
        if (!depths.is_common() || depths.sum() <= best_.depth) return false;
        best_ = {depths.sum(), p};
        return true;
    }

    void add(const Vec3& center, const Vec3& half)
    {
        if (left_ == 0) return;
        const Depths depths = depths_at(center);
        if (depths.is_common() && depths.sum() > best_.depth) best_ = {depths.sum(), center};
        // No point of the box is deeper in either by more than its distance from the middle.
        const double reach = length_of(half);
        if (depths.in_a + reach < 0 || depths.in_b + reach < 0) return;
        const double most = depths.sum() + 2 * reach;
        if (most <= best_.depth) return;
        cells_.push({most, center, half, next_++});
    }

    /// From the best point on, along the axes, by smaller and smaller steps.
    void climb(double step)
    {
        if (best_.depth <= 0) return;
        left_ = 600;
        const double least = 1e-7 * step;
        while (step > least && left_ > 6) {
            bool better = false;
            for (int axis = 0; axis < 3; ++axis) {
                for (const double sign : {1.0, -1.0})
                    better = improve(best_.point + sign * step * Vec3::Unit(axis)) || better;
            }
            if (!better) step *= 0.5;
        }
    }

    const SolidParts& a_;
    const SolidParts& b_;
    RigidTransform back_;
    std::uint32_t left_;
    const Progress* progress_;
    std::uint32_t next_ = 0;
    DeepestPoint best_;
    std::priority_queue<SearchCell> cells_;
};

} // namespace

DeepestPoint find_deepest_point(const SolidParts& a, const SolidParts& b,
                                const RigidTransform& pose_b, std::uint32_t max_points,
                                const Progress* progress)
{
    const Box box_a = hull_box(a.hull, {});
    const Box box_b = hull_box(b.hull, pose_b);
    const Box box = {box_a.lower.cwiseMax(box_b.lower), box_a.upper.cwiseMin(box_b.upper)};
    if (box.empty() || max_points == 0) return {};
    return DeepestSearch(a, b, pose_b, max_points, progress).find(box);
}

} // namespace proxima
