#include "haptics/tool/triangle_separation.h"

#include "haptics/tool/closest_directions.h"

#include <algorithm>
#include <limits>

namespace proxima {

namespace {

constexpr int max_advances = 24;
constexpr int max_halvings = 12;

double least_along(const Vec3& n, const Triangle& triangle) noexcept
{
    return std::min({n.dot(triangle[0]), n.dot(triangle[1]), n.dot(triangle[2])});
}
double most_along(const Vec3& n, const Triangle& triangle) noexcept
{
    return std::max({n.dot(triangle[0]), n.dot(triangle[1]), n.dot(triangle[2])});
}

/// Takes the plane with that normal that touches the scene's triangle.
void set_plane(NearPair& pair, const Vec3& normal) noexcept
{
    pair.normal = normal;
    pair.offset = most_along(normal, pair.scene);
}

/// Whether a height is at least `least` between two ends: it is off their chord by at most
/// 4 t (1 - t) error.
bool keeps_gap(double begin, double end, double error, double least) noexcept
{
    const double lower = std::min(begin, end);
    const double higher = std::max(begin, end);
    return lower >= least + error || (lower >= least && higher >= least + 4 * error);
}

double arc_error(const NearPair& pair, const Twist& twist, double part) noexcept
{
    return chord_error(part * twist.angular.norm(), pair.reach);
}

double largest_reach(std::span<NearPair* const> pairs) noexcept
{
    double reach = 0;
    for (const NearPair* const pair : pairs) reach = std::max(reach, pair->reach);
    return reach;
}

/// How near a pair may come that begins with that gap.
double floor_of(double gap, const GapLimits& limits) noexcept
{
    return gap < limits.near ? std::min(limits.least, gap * (1 - 1e-9)) : limits.wanted;
}

/// The part of the motion in which no point moves by more than the gaps of the pairs' planes leave.
double known_free_part(std::span<NearPair* const> pairs, const ToolMotion& motion,
                       const GapLimits& limits) noexcept
{
    double part = 1;
    for (const NearPair* const pair : pairs) {
        const double gap = plane_gap(*pair, motion.from);
        const double room = gap - floor_of(gap, limits);
        const double length = motion.twist.path_length(pair->reach);
        if (length * part > room) part = gap > 0 ? std::max(room, 0.0) / length : 0;
    }
    return part;
}

} // namespace

void set_normal(NearPair& pair, const Vec3& across) noexcept
{
    const double length = across.norm();
    pair.normal = Vec3::Zero();
    if (length > 0) set_plane(pair, across / length);
}

double plane_gap(const NearPair& pair, const RigidTransform& pose) noexcept
{
    if (pair.normal.isZero(0)) return -std::numeric_limits<double>::infinity();
    // Turning the normal back costs less than moving three corners.
    const Vec3 turned = pose.rotation.transpose() * pair.normal;
    return least_along(turned, pair.tool) + (pair.normal.dot(pose.translation) - pair.offset);
}

bool stays_apart(const NearPair& pair, const ToolMotion& motion, double least) noexcept
{
    return keeps_gap(plane_gap(pair, motion.from), plane_gap(pair, motion.to),
                     arc_error(pair, motion.twist, 1), least);
}

bool find_plane(NearPair& pair, const ToolMotion& motion, double least, const Vec3& other) noexcept
{
    if (!other.isZero(0)) {
        set_plane(pair, other);
        if (stays_apart(pair, motion, least)) return true;
    }
    const Triangle tool = motion.from(pair.tool);
    for (const Triangle& face : {pair.scene, tool}) {
        const Vec3 scaled = scaled_normal(face);
        const double length = scaled.norm();
        if (!(length > 0)) continue;
        const Vec3 normal = scaled / length;
        const bool above = least_along(normal, tool) - most_along(normal, pair.scene) >
                           least_along(-normal, tool) - most_along(-normal, pair.scene);
        set_plane(pair, above ? normal : Vec3(-normal));
        if (stays_apart(pair, motion, least)) return true;
    }
    return false;
}

void set_closest_planes(std::span<NearPair* const> pairs, const RigidTransform& pose) noexcept
{
    EightTrianglePairs eight;
    EightDirections directions;
    constexpr std::size_t lanes = closest_planes_at_once;
    for (std::size_t first = 0; first < pairs.size(); first += lanes) {
        const std::size_t count = std::min(lanes, pairs.size() - first);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const NearPair& pair = *pairs[first + std::min(lane, count - 1)];
            for (std::size_t corner = 0; corner < 3; ++corner) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const auto at = static_cast<Eigen::Index>(axis);
                    eight.scene[corner][axis][lane] = pair.scene.vertices[corner][at];
                    eight.tool[corner][axis][lane] = pair.tool.vertices[corner][at];
                }
            }
        }
        find_closest_directions(eight, pose, directions);
        for (std::size_t lane = 0; lane < count; ++lane) {
            const auto& across = directions.across;
            set_normal(*pairs[first + lane],
                       Vec3(across[0][lane], across[1][lane], across[2][lane]));
        }
    }
}

double free_part(std::span<NearPair*> pairs, const ToolMotion& motion, const GapLimits& limits,
                 ToolEffort& effort) noexcept
{
    double part = 0;
    for (int advance = 0; advance < max_advances; ++advance) {
        if (!effort.begin(closest_planes_work(pairs.size())))
            return advance == 0 ? known_free_part(pairs, motion, limits) : part;
        const RigidTransform at = moved_by(motion.from, motion.twist, part);
        set_closest_planes(pairs, at);
        // Pairs whose planes hold to the end are done.
        std::size_t left = 0;
        for (NearPair* const pair : pairs) {
            const double gap = plane_gap(*pair, at);
            if (!(gap > 0)) return part;
            if (advance == 0) pair->floor = floor_of(gap, limits);
            if (!keeps_gap(gap, plane_gap(*pair, motion.to),
                           arc_error(*pair, motion.twist, 1 - part), pair->floor))
                pairs[left++] = pair;
        }
        pairs = pairs.first(left);
        if (pairs.empty()) return 1;
        // As far as all corners come towards their planes, if they went straight on.
        double step = 1 - part;
        for (const NearPair* const pair : pairs) {
            const Triangle tool = at(pair->tool);
            for (const Vec3& corner : tool.vertices) {
                const Vec3 arm = corner - at.translation;
                const double speed =
                    -pair->normal.dot(motion.twist.linear + motion.twist.angular.cross(arm));
                const double room = pair->normal.dot(corner) - pair->offset - pair->floor;
                if (speed * step > room) step = std::max(room, 0.0) / speed;
            }
        }
        bool proven = false;
        for (int halving = 0; halving < max_halvings && !proven; ++halving) {
            const RigidTransform next = moved_by(motion.from, motion.twist, part + step);
            proven = std::ranges::all_of(pairs, [&](const NearPair* pair) {
                return keeps_gap(plane_gap(*pair, at), plane_gap(*pair, next),
                                 arc_error(*pair, motion.twist, step), pair->floor);
            });
            if (!proven) step *= step < 1 - part ? 0.9 : 0.5;
            if (!proven && halving > 1) step *= 0.5;
        }
        if (!proven) return part;
        part += step;
        // What is left of the gap would not carry the motion on.
        if (step * motion.twist.path_length(largest_reach(pairs)) < 1e-3 * limits.least)
            return part;
    }
    return part;
}

} // namespace proxima
