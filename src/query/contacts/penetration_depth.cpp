#include "base/check.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/length.h"
#include "proxima/closest_feature.h"
#include "proxima/contacts.h"
#include "proxima/minkowski_sum.h"
#include "query/contact/enclosure_parts.h"
#include "query/contacts/deepest_point.h"
#include "query/contacts/hull_depth.h"
#include "query/contacts/overlap.h"
#include "query/contacts/solid_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace proxima {

namespace {

double largest_component(const Vec3& v)
{
    return v.cwiseAbs().maxCoeff();
}

/// Points along a spiral over the unit sphere, all but evenly.
Vec3 spiral_direction(std::uint32_t i, std::uint32_t count)
{
    const double z = 1 - (2.0 * i + 1.0) / count;
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
    const double radius = std::sqrt(std::max(0.0, 1 - z * z));
    return Vec3(radius * std::cos(turn), radius * std::sin(turn), z).normalized();
}

// The steps of penetration_depth.
//
// Rounding. u = 2^-53, S the sum of the largest coordinates of A and B and of the translation, times the root
// of 3. Corners of B moved are off by 8 u S, supports n . x by 4 u S, facets' normals, which are right
// to a few roundings of their length, shift the sum's planes by 8 u S, and t n added to the translation is
// off by 2 u S. Together these are below 2^-48 S, which is `slack_`. Distances of points are off by 16 u S in
// A and in B, and a point moved back by 16 u S, the inverse matrix included: below twice the slack. The pose's
// matrix may be no rotation by rotation_error e. Points are moved back by its inverse, not by its
// transpose, and a ball of B becomes an ellipsoid whose half axes are at least 1 - e times its radius.
class PenetrationSearch {
public:
    PenetrationSearch(const SolidParts& a, const SolidParts& b, const RigidTransform& pose_b,
                      const PenetrationOptions& options)
        : a_(a), b_(b), pose_(pose_b), options_(options), overlap_(a, b)
    {
        constexpr double root_of_three = 1.7320508075688774;
        const double coordinates =
            a.largest + 2 * b.largest + largest_component(pose_b.translation);
        constexpr double smallest_steps = 64 * std::numeric_limits<double>::denorm_min();
        slack_ = 0x1p-48 * root_of_three * coordinates + smallest_steps;
        for (const Vec3& p : b.hull.points()) moved_.push_back(pose_b(p));
    }

    Result<PenetrationDepth> find()
    {
        if (!overlap_(pose_)) return PenetrationDepth{};
        const auto hulls = hull_depth();
        if (!hulls) return tl::unexpected(hulls.error());
        take(hulls->direction, hull_reach(hulls->direction));
        if (a_.is_convex && b_.is_convex) {
            answer_.method = PenetrationMethod::convex;
            const double error = a_.hull_error + b_.hull_error * (1 + stretch()) + slack_;
            answer_.lower = std::max(0.0, hulls->lower - error);
            answer_.deepest = hulls->common ? *hulls->common : common_point();
            if (is_cancelled(options_.execution.progress)) return stopped();
        } else {
            answer_.method = PenetrationMethod::bounds;
            bound_from_below();
            if (is_cancelled(options_.execution.progress)) return stopped();
            if (!bound_from_above()) return stopped();
        }
        // Both are proven, roundings included. If they crossed all the same, the upper one counts: its
        // translation is seen to part the hulls or, exactly, the meshes.
        answer_.lower = std::min(answer_.lower, answer_.upper);
        return answer_;
    }

private:
    static tl::unexpected<Error> stopped() { return cancelled("finding the penetration depth"); }

    struct HullAnswer {
        double lower; ///< but for the slack
        Vec3 direction;
        std::optional<Vec3> common;
    };

    /// By few points of the Minkowski sum or, where these do not say it, by all of it.
    [[nodiscard]] Result<HullAnswer> hull_depth() const
    {
        if (const auto few = find_hull_depth(a_.hull, b_.hull, moved_, slack_))
            return HullAnswer{few->lower, few->direction, few->common};
        auto moved = convex_hull(moved_, {}, options_.execution);
        if (!moved) return tl::unexpected(moved.error());
        const auto between = separation(a_.hull, *moved, {.execution = options_.execution});
        if (!between) return tl::unexpected(between.error());
        return HullAnswer{std::max(0.0, -between->distance), between->direction, std::nullopt};
    }

    /// B moved this far along the direction is beyond A, as their hulls are: surely.
    [[nodiscard]] double hull_reach(const Vec3& direction) const
    {
        double top = -HUGE_VAL;
        for (const Vec3& p : a_.hull.points()) top = std::max(top, direction.dot(p));
        double least = HUGE_VAL;
        for (const Vec3& p : moved_) least = std::min(least, direction.dot(p));
        return std::max(0.0, top - least) + slack_;
    }

    /// Of convex meshes.
    [[nodiscard]] Vec3 common_point() const
    {
        constexpr std::uint32_t few_points = 200;
        const DeepestPoint found =
            find_deepest_point(a_, b_, pose_, few_points, options_.execution.progress);
        return found.depth > 0 ? found.point : point_of_both();
    }

    /// Where the search found none: overlaps that are small beside the meshes.
    [[nodiscard]] Vec3 point_of_both() const
    {
        const auto found = intersection_contour(a_.index, b_.index, pose_, {options_.execution});
        if (!found) return Vec3::Zero(); // cancelled, as the caller will see
        const IntersectionContour& contour = *found;
        if (contour.points.empty()) { // one part is inside the other mesh
            for (const Vec3& p : a_.enclosure.parts().vertices)
                if (encloses(b_.enclosure, pose_, p)) return p;
            for (const Vec3& p : b_.enclosure.parts().vertices)
                if (encloses(a_.enclosure, {}, pose_(p))) return pose_(p);
        }
        PROXIMA_CHECK(!contour.points.empty()); // they overlap
        const Vec3& first = contour.points.front().position;
        if (answer_.method != PenetrationMethod::convex) return first;
        // What two convex solids have in common is convex, so the mean of its points belongs to it.
        Vec3 sum = Vec3::Zero();
        for (const ContourPoint& point : contour.points) sum += point.position - first;
        return first + sum / static_cast<double>(contour.points.size());
    }

    /// How much distances change where the pose's matrix is no rotation.
    [[nodiscard]] double stretch() const
    {
        std::array<double, 12> rows{};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k)
                rows[4 * i + k] = pose_.rotation(static_cast<int>(i), static_cast<int>(k));
        }
        return 2 * rotation_error(rows) + 0x1p-48;
    }

    void bound_from_below()
    {
        const DeepestPoint found =
            find_deepest_point(a_, b_, pose_, options_.max_points, options_.execution.progress);
        constexpr double least = 1e-150; // of what is smaller, squares of distances vanish
        if (found.depth >= least)
            answer_.lower = std::max(0.0, found.depth * (1 - stretch()) - 2 * slack_);
        answer_.deepest = found.depth > 0 ? found.point : point_of_both();
    }

    [[nodiscard]] bool is_free(const Vec3& direction, double distance)
    {
        return !overlap_({pose_.rotation, pose_.translation + distance * direction});
    }

    /// What moving along a direction to a distance is, roundings included.
    [[nodiscard]] double bound_of(double distance) const { return distance + slack_; }

    /// Looks for less than the least upper bound along a direction. Being free is not monotonic: a
    /// few distances are tried, and then the one where it begins to be free is closed in on.
    bool shorten(const Vec3& direction, std::span<const double> parts)
    {
        const double reach = hull_reach(direction);
        if (bound_of(reach) < answer_.upper) take(direction, reach);
        double bound = std::min(answer_.upper, reach);
        const double least = answer_.lower;
        std::optional<double> free;
        double blocked = least;
        for (const double part : parts) { // descending
            const double distance = least + part * (bound - least);
            if (is_free(direction, distance)) {
                free = distance;
            } else if (free) {
                blocked = distance;
                break;
            }
        }
        if (!free) return false;
        constexpr double close = 1e-6;
        while (*free - blocked > std::max(close * *free, slack_)) {
            const double middle = 0.5 * (*free + blocked);
            if (middle <= blocked || middle >= *free) break;
            (is_free(direction, middle) ? *free : blocked) = middle;
        }
        if (bound_of(*free) >= answer_.upper) return false;
        take(direction, *free);
        return true;
    }

    void take(const Vec3& direction, double distance)
    {
        answer_.upper = bound_of(distance);
        answer_.direction = direction;
        answer_.translation = distance * direction;
    }

    /// Directions by hull, axes, surfaces near the deepest point, and all round; then turned a little.
    /// False where cancelled.
    bool bound_from_above()
    {
        std::vector<Vec3> directions = {answer_.direction};
        for (int axis = 0; axis < 3; ++axis) {
            directions.emplace_back(Vec3::Unit(axis));
            directions.emplace_back(-Vec3::Unit(axis));
            const Vec3 own = pose_.rotation.col(axis).normalized();
            directions.push_back(own);
            directions.emplace_back(-own);
        }
        add_surfaces(directions);
        const std::size_t fixed = directions.size();
        const std::size_t count = fixed + options_.max_directions;
        constexpr std::array<double, 6> parts = {0.97, 0.75, 0.5, 0.25, 0.1, 0.03};
        begin_stage(options_.execution.progress, "separating meshes", count);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3 direction = i < fixed
                                       ? directions[i]
                                       : spiral_direction(static_cast<std::uint32_t>(i - fixed),
                                                          options_.max_directions);
            if (is_cancelled(options_.execution.progress)) return false;
            shorten(direction, parts);
            advance_stage(options_.execution.progress, 1);
        }
        return turn_a_little();
    }

    /// From the deepest point, to where it leaves A and B.
    void add_surfaces(std::vector<Vec3>& directions) const
    {
        const auto add = [&](const Vec3& direction) {
            const Vec3 unit = unit_of(direction);
            if (unit.allFinite() && unit.squaredNorm() > 0.5) directions.push_back(unit);
        };
        const Vec3& p = answer_.deepest;
        if (const auto out = closest_feature(a_.index, p)) add(out->point - p);
        const Vec3 there = true_inverse(pose_)(p);
        if (const auto out = closest_feature(b_.index, there))
            add(pose_.rotation * (there - out->point));
    }

    bool turn_a_little()
    {
        constexpr double widest = 0.25;
        constexpr double narrowest = 1e-3;
        for (double angle = widest; angle > narrowest;) {
            if (is_cancelled(options_.execution.progress)) return false;
            const Vec3 middle = answer_.direction;
            const Vec3 aside = middle.unitOrthogonal();
            const Vec3 other = middle.cross(aside);
            const double before = answer_.upper;
            const std::array<double, 1> part = {1 - std::max(0.1 * angle * angle, 1e-5)};
            constexpr int around = 6;
            for (int i = 0; i < around; ++i) {
                const double turn = 2 * std::numbers::pi * i / around;
                const Vec3 side = std::cos(turn) * aside + std::sin(turn) * other;
                shorten((middle + angle * side).normalized(), part);
            }
            if (!(answer_.upper < before)) angle *= 0.5;
        }
        return true;
    }

    const SolidParts& a_;
    const SolidParts& b_;
    RigidTransform pose_;
    const PenetrationOptions& options_;
    SolidOverlap overlap_;
    std::vector<Vec3> moved_; ///< corners of B's hull
    double slack_ = 0;
    PenetrationDepth answer_;
};

} // namespace

Status check_pose(const RigidTransform& pose_b)
{
    if (!pose_b.rotation.allFinite() || !pose_b.translation.allFinite()) {
        return fail(ErrorCode::invalid_argument,
                    "a number of B's pose is NaN or infinite: give finite ones");
    }
    const Mat3 square = pose_b.rotation.transpose() * pose_b.rotation;
    if ((square - Mat3::Identity()).norm() <= nearly_rigid_tolerance) return {};
    return fail(ErrorCode::invalid_argument,
                "the matrix of B's pose is no rotation: give three orthogonal rows of length 1");
}

Result<PenetrationDepth> penetration_depth(const Solid& a, const Solid& b,
                                           const RigidTransform& pose_b,
                                           const PenetrationOptions& options)
{
    if (Status status = check_pose(pose_b); !status) return tl::unexpected(status.error());
    if (std::max(options.max_points, options.max_directions) > max_penetration_search) {
        return fail(ErrorCode::limit_exceeded,
                    concat("at most ", max_penetration_search,
                           " points and as many directions can be looked at: ask for fewer"));
    }
    return PenetrationSearch(a.parts(), b.parts(), pose_b, options).find();
}

} // namespace proxima
