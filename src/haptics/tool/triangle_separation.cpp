#include "haptics/tool/triangle_separation.h"

#include "geometry/triangle_distance.h"

#include <algorithm>
#include <limits>

namespace proxima {

namespace {

constexpr int max_advances = 24;

Triangle moved(const Triangle& triangle, const RigidTransform& pose) noexcept
{
    return pose(triangle);
}

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

/// Takes the plane across the closest points. Returns their distance, 0 where the triangles meet.
double set_closest_plane(NearPair& pair, const Triangle& tool) noexcept
{
    const ClosestTrianglePoints closest = closest_points(pair.scene, tool);
    const Vec3 across = closest.second.point - closest.first.point;
    const double distance = across.norm();
    if (!(closest.squared_distance > 0) || !(distance > 0)) return 0;
    set_plane(pair, across / distance);
    return distance;
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

bool find_plane(NearPair& pair, const ToolMotion& motion, double least, Vec3& last) noexcept
{
    if (!last.isZero(0)) {
        set_plane(pair, last);
        if (stays_apart(pair, motion, least)) return true;
    }
    const Triangle tool = moved(pair.tool, motion.from);
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
    if (!(set_closest_plane(pair, tool) > 0)) return false;
    last = pair.normal;
    return stays_apart(pair, motion, least);
}

double free_part(NearPair& pair, const ToolMotion& motion, const GapLimits& limits,
                 double most) noexcept
{
    double part = 0;
    double floor = limits.wanted;
    for (int advance = 0; advance < max_advances; ++advance) {
        const RigidTransform at = moved_by(motion.from, motion.twist, part);
        const Triangle tool = moved(pair.tool, at);
        const double distance = set_closest_plane(pair, tool);
        if (!(distance > 0)) return part;
        if (advance == 0 && distance < limits.near)
            floor = std::min(limits.least, distance * (1 - 1e-9));
        // As far as the corners come towards the plane, if they went straight on.
        double step = most - part;
        for (const Vec3& corner : tool.vertices) {
            const Vec3 arm = corner - at.translation;
            const double speed =
                -pair.normal.dot(motion.twist.linear + motion.twist.angular.cross(arm));
            const double height = pair.normal.dot(corner) - pair.offset;
            if (speed * step > height - floor) step = std::max(height - floor, 0.0) / speed;
        }
        bool proven = false;
        for (int halving = 0; halving < 6 && !proven; ++halving) {
            const RigidTransform next = moved_by(motion.from, motion.twist, part + step);
            proven = keeps_gap(distance, plane_gap(pair, next), arc_error(pair, motion.twist, step),
                               floor);
            if (!proven) step *= step < most - part ? 0.9 : 0.5;
            if (!proven && halving > 1) step *= 0.5;
        }
        if (!proven) return part;
        part += step;
        if (part >= most) return most;
        // What is left of the gap would not carry the motion on.
        if (step * motion.twist.path_length(pair.reach) < 1e-3 * limits.least) return part;
    }
    return part;
}

} // namespace proxima
