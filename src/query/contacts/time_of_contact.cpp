#include "proxima/time_of_contact.h"

#include "base/check.h"
#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_distance.h"
#include "index/index_parts.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "query/distance/near_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace proxima {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Corners of a box about all triangles, in the mesh's own coordinates.
std::array<Vec3, 8> corners_around(const IndexParts& index)
{
    const RootBox& box = index.root_box();
    std::array<Vec3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double at = (i >> axis & 1U) != 0 ? box.upper[axis] : box.lower[axis];
            corners[i][static_cast<int>(axis)] =
                index.center()[static_cast<int>(axis)] + at * index.unscale();
        }
    }
    return corners;
}

double size_of(const Vec3& v)
{
    return v.cwiseAbs().maxCoeff();
}

/// The first time s > 0 at which speed s + bend s^2 reaches the gap. \pre gap > 0, bend >= 0
double time_to_close(double gap, double speed, double bend)
{
    const double root = std::sqrt(speed * speed + 4 * bend * gap);
    if (speed > 0) return 2 * gap / (speed + root);
    return bend > 0 ? (root - speed) / (2 * bend) : never;
}

// Bounds of a motion: how long from a time on no point of B can reach A.
//
// All lengths are taken times `unit_`, a power of two that makes the largest coordinate about 1.
//
// A point of B at r from the center moves, from time t to t + s, by
//     s (displacement + turn x r) + what is at most s^2 |turn| |turn x r| / 2,
// for the path of r is a circle about the turn's axis: along a direction n at most |n x axis| times that, as
// the circle lies across the axis. It never moves faster than
//     fastest = |displacement| + max |turn x r|,
// and |turn x r| does not change with time. A box's corners bound the maximum.
//
// Rounding. u = 2^-53, S the sum of the largest distances from the origin of A's and B's corners as given, of
// the center and its path. Sine and cosine are off by u (1 + 3 angle), R by at most u (32 + 16 angle) as a
// map, moved corners by that much of |p| + |center| and by 8 u S. This counts twice, for the poses
// before and after the step. Distances and projections of corners are off by 32 u S at most, and so
// is the step's own arithmetic. Together less than u S (128 + 32 angle); the margin is twice that.
class MotionBounds {
public:
    MotionBounds(const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion)
        : a_(a), b_(b), motion_(motion), angle_(motion.turn.stableNorm()),
          axis_(motion.turn.stableNormalized())
    {
        const Vec3 start = motion.start(motion.center);
        double coordinates = size_of(start) + size_of(motion.displacement) + size_of(motion.center);
        double largest = 0;
        for (const Vec3& corner : corners_around(a.parts()))
            largest = std::max(largest, size_of(corner));
        coordinates += largest;
        largest = 0;
        const auto corners = corners_around(b.parts());
        for (const Vec3& corner : corners) largest = std::max(largest, size_of(corner));
        coordinates += largest;
        constexpr int most = 1000; // so that 1 / unit is a double, too
        const int exponent = coordinates > 0 ? std::ilogb(coordinates) : 0;
        unit_ = std::ldexp(1.0, std::clamp(-exponent, -most, most));
        constexpr double root_of_three = 1.7320508075688774; // largest component to length
        margin_ = 0x1p-45 * (1 + angle_ / 4) * root_of_three * (coordinates * unit_);
        displacement_ = motion.displacement * unit_;
        double turning = 0;
        for (const Vec3& corner : corners) {
            const Vec3 arm = motion.start.rotation * ((corner - motion.center) * unit_);
            turning = std::max(turning, motion.turn.cross(arm).norm());
        }
        fastest_ = (displacement_.norm() + turning) * (1 + 0x1p-40);
    }

    /// How far B may go on from `time`, where the meshes are `nearest`, without a contact. 0 where
    /// rounding lets nothing be said.
    double step(double time, const RigidTransform& pose, const MeshDistance& nearest)
    {
        const double distance = nearest.distance * unit_;
        const double plain = fastest_ > 0 ? (distance - margin_) / fastest_ : never;
        normal_ = (nearest.point_b - nearest.point_a).stableNormalized();
        if (time + plain >= 1) return plain;
        const double by_pairs = step_by_pairs(time, pose, distance);
        constexpr double rounded_down = 1 - 0x1p-40;
        return std::max({plain, by_pairs, 0.0}) * rounded_down;
    }

    /// The time in which the fastest point moves as far as roundings let nothing be said.
    [[nodiscard]] double rounding() const { return fastest_ > 0 ? margin_ / fastest_ : 1; }

    /// The direction that kept the pair apart that ended the last step.
    [[nodiscard]] const Vec3& normal() const { return normal_; }

private:
    /// All pairs within a reach, one by one; what is farther needs the time of the fastest point.
    double step_by_pairs(double time, const RigidTransform& pose, double distance)
    {
        NearRowsAnswer near;
        double reach = 0;
        for (int attempt = 0;; ++attempt) {
            reach = factor_ * distance + margin_;
            near = near_rows(a_, b_, pose, reach / unit_, rows_);
            if (near.complete) break;
            constexpr int attempts = 2;
            most_reach_ = reach;
            if (attempt == attempts) return 0;
            factor_ = 1 + (factor_ - 1) / 4;
        }
        const double beyond = (reach - margin_) / fastest_;
        double least = beyond;
        const Vec3 center = (motion_.start(motion_.center) + time * motion_.displacement) * unit_;
        // The order of pairs, and those that are farther than the reach, depend on the instruction set.
        // The least step does not: a pair's is the longest of directions that doubles give.
        const Vec3 direction = normal_;
        std::uint64_t which = 0;
        for (std::size_t i = 0; i < near.count; ++i) {
            const NearRows& rows = rows_[i];
            const Pair pair = {scaled(a_.parts().triangle(rows.a)),
                               scaled(pose(b_.parts().triangle(rows.b))), center};
            // That of the nearest pair will often do to say that others meet sooner.
            PairStep step = {step_along(pair, direction), direction};
            if (step.time > least) continue;
            if (!lengthen(pair, reach, step) || step.time > least) continue;
            const std::uint64_t number = std::uint64_t{rows.a} << 32U | rows.b;
            if (step.time == least && (least == beyond || number > which)) continue;
            least = step.time;
            normal_ = step.normal;
            which = number;
        }
        // Nothing near was in the way: look farther, but for where there were too many pairs.
        if (least == beyond && 8 * reach < most_reach_) factor_ *= 8;
        most_reach_ *= 2;
        return least;
    }

    struct Pair {
        Triangle a;
        Triangle b;
        Vec3 center;
    };

    [[nodiscard]] Triangle scaled(const Triangle& t) const
    {
        return {{Vec3(t[0] * unit_), Vec3(t[1] * unit_), Vec3(t[2] * unit_)}};
    }

    /// How long the triangles are sure to be apart along a direction from A's to B's.
    [[nodiscard]] double step_along(const Pair& pair, const Vec3& direction) const
    {
        double top = -never;
        for (const Vec3& p : pair.a.vertices) top = std::max(top, direction.dot(p));
        double least = never;
        // Points turn about the axis, so they are never accelerated along it.
        const double across_axis = std::min(1.0, direction.cross(axis_).norm() + 0x1p-48);
        for (const Vec3& p : pair.b.vertices) {
            const double gap = direction.dot(p) - top - margin_;
            if (!(gap > 0)) return 0;
            const Vec3 turning = motion_.turn.cross(p - pair.center);
            const double towards = -direction.dot(displacement_ + turning);
            least = std::min(
                least, time_to_close(gap, towards, across_axis * 0.5 * angle_ * turning.norm()));
        }
        return least;
    }

    /// How long a pair is sure to be apart, and the direction that shows it.
    struct PairStep {
        double time;
        Vec3 normal;
    };

    /// Takes the longest step of several directions. False where the pair is farther than the reach.
    bool lengthen(const Pair& pair, double reach, PairStep& best) const
    {
        const ClosestTrianglePoints closest = closest_points(pair.a, pair.b);
        if (std::sqrt(closest.squared_distance) > reach) return false;
        const Vec3 across = closest.second.point - closest.first.point;
        const auto try_along = [&](const Vec3& direction) {
            const double step = step_along(pair, direction);
            if (step > best.time) best = {step, direction};
        };
        const auto consider = [&](const Vec3& u, const Vec3& v) {
            const Vec3 direction = unit_normal({Vec3::Zero(), u}, {Vec3::Zero(), v});
            try_along(direction.dot(across) < 0 ? Vec3(-direction) : direction);
        };
        try_along(across.stableNormalized());
        // Points that are all but one say little about the direction; the triangles say it.
        const auto side = [](const Triangle& t, int i) { return Vec3(t[(i + 1) % 3] - t[i]); };
        consider(side(pair.a, 0), side(pair.a, 1));
        consider(side(pair.b, 0), side(pair.b, 1));
        const auto number = [](TrianglePart part) {
            return part >= TrianglePart::side_0 && part <= TrianglePart::side_2
                       ? static_cast<int>(part) - static_cast<int>(TrianglePart::side_0)
                       : -1;
        };
        const int on_a = number(closest.first.part);
        const int on_b = number(closest.second.part);
        if (on_a >= 0 && on_b >= 0) consider(side(pair.a, on_a), side(pair.b, on_b));
        return true;
    }

    const MeshIndex& a_;
    const MeshIndex& b_;
    const RigidMotion& motion_;
    double angle_;
    Vec3 axis_; ///< of length 1, or 0
    double unit_ = 1;
    double margin_ = 0;
    Vec3 displacement_;
    double fastest_ = 0;
    double factor_ = 4;         ///< reach of pairs, in distances of the meshes
    double most_reach_ = never; ///< where there were too many
    Vec3 normal_ = Vec3::Zero();
    static constexpr std::size_t most_pairs = 256;
    std::array<NearRows, most_pairs> rows_;
};

void fill(TimeOfContact& answer, double time, const RigidTransform& pose,
          const MeshDistance& nearest, const Vec3& normal)
{
    answer.free_until = time;
    answer.free_pose = pose;
    answer.distance = nearest.distance;
    answer.point_a = nearest.point_a;
    answer.point_b = nearest.point_b;
    answer.triangle_a = nearest.triangle_a;
    answer.triangle_b = nearest.triangle_b;
    answer.normal = normal;
}

} // namespace

std::optional<TimeOfContact> time_of_contact(const MeshIndex& a, const MeshIndex& b,
                                             const RigidMotion& motion,
                                             const TimeOfContactOptions& options) noexcept
{
    if (a.triangle_count() == 0 || b.triangle_count() == 0) return std::nullopt;
    PROXIMA_CHECK(motion.turn.stableNorm() <= max_motion_turn);
    MotionBounds bounds(a, b, motion);
    const double tolerance = options.tolerance > 0 ? std::min(options.tolerance, 1.0) : 0;
    TimeOfContact answer;
    RigidTransform pose = motion.start;
    MeshDistance nearest = mesh_distance(a, b, pose).value_or(MeshDistance{});
    answer.steps = 1;
    if (nearest.distance == 0) { // exactly if they meet
        fill(answer, 0, pose, nearest, Vec3::Zero());
        return answer;
    }
    MeshMeeting meeting;
    for (double time = 0;;) {
        const double step = bounds.step(time, pose, nearest);
        if (time + step >= 1) return std::nullopt;
        const bool is_stuck = time + step == time;
        if (step < tolerance || is_stuck) {
            // Is there a contact within the tolerance, or where roundings end?
            std::array<double, 4> probes = {tolerance, 4 * bounds.rounding(),
                                            16 * bounds.rounding(), 64 * bounds.rounding()};
            const auto tried = std::span(probes).first(is_stuck ? probes.size() : 1);
            std::ranges::sort(tried);
            for (const double within : tried) {
                const double next_time = std::nextafter(time, 2.0);
                const double probe = std::min(1.0, std::max(time + within, next_time));
                if (const auto found =
                        find_meeting(a, b, pose_at(motion, probe), {.start_from = &meeting})) {
                    fill(answer, time, pose, nearest, bounds.normal());
                    answer.touches_at = probe;
                    return answer;
                }
            }
        }
        if (is_stuck || answer.steps >= options.max_steps) {
            fill(answer, time, pose, nearest, bounds.normal());
            answer.touches_at = never;
            answer.evidence = is_stuck ? ContactEvidence::rounding : ContactEvidence::steps;
            return answer;
        }
        const double next = time + step;
        const RigidTransform next_pose = pose_at(motion, next);
        const MeshDistance there =
            mesh_distance(a, b, next_pose, {.start_from = &nearest}).value_or(MeshDistance{});
        ++answer.steps;
        time = next;
        pose = next_pose;
        nearest = there;
    }
}

} // namespace proxima
