// A hand that touches an object whose shape changes, and what every vertex of it does, apart from the
// library: a tick is held against all triangles.
#pragma once

#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/servo_tick.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace proxima::testing {

inline constexpr double frame_seconds = 1.0 / 60;

inline const WorkspaceMap same_unit{};
inline const Box room{Vec3(-1, -1, -1), Vec3(1, 1, 1)};

inline DeviceLimits strong_device()
{
    return {.name = "strong",
            .max_force = 1e4,
            .max_stiffness = 1e5,
            .max_damping = 100,
            .workspace_radius = 1};
}

inline RenderOptions plain(double friction, double radius)
{
    RenderOptions options;
    options.force = {.stiffness = 500, .damping = 0, .max_slew = 1e9, .start_seconds = 0};
    options.proxy_radius = radius;
    options.static_friction = friction;
    options.dynamic_friction = 0.75 * friction;
    options.guard = Guard::off;
    options.max_jump = 10;
    return options;
}

inline DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

/// A cloth of 20 cm, flat, of 2 cells^2 triangles.
inline TriangleMesh flat_cloth(std::uint32_t cells)
{
    return moved(bumpy_sheet(cells),
                 [](const Vec3& p) { return Vec3(0.1 * p.x(), 0.1 * p.y(), 0); });
}

/// A wave that runs over a cloth in a direction.
struct Wave {
    double height;
    double hertz;
    double length;
    double phase;
    double direction;

    [[nodiscard]] std::vector<Vec3> positions(const TriangleMesh& flat, double seconds) const
    {
        constexpr double turn = 2 * std::numbers::pi;
        std::vector<Vec3> result(flat.positions().begin(), flat.positions().end());
        for (Vec3& p : result) {
            const double along = std::cos(direction) * p.x() + std::sin(direction) * p.y();
            const double angle = turn * (along / length - hertz * seconds) + phase;
            p += height * Vec3(0.3 * std::cos(angle), 0.2 * std::sin(angle), std::sin(angle));
        }
        return result;
    }
};

inline double determinant(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return a.dot(b.cross(c));
}

/// Whether a point that moves evenly meets a triangle whose corners do. The volume that both span is
/// a cubic polynomial of time, here by its Bernstein coefficients: where all of a part have one sign,
/// it is not zero there. Parts with both signs are halved.
class Crossing {
public:
    Crossing(const Triangle& before, const Triangle& now, const Vec3& from, const Vec3& to)
    {
        for (int k = 0; k < 3; ++k) {
            begin_[k] = before[k] - from;
            end_[k] = now[k] - to;
        }
    }

    [[nodiscard]] bool happens() const
    {
        const auto& [a, b, c] = begin_;
        const auto& [d, e, f] = end_;
        return search({determinant(a, b, c),
                       (determinant(a, b, f) + determinant(a, e, c) + determinant(d, b, c)) / 3,
                       (determinant(a, e, f) + determinant(d, b, f) + determinant(d, e, c)) / 3,
                       determinant(d, e, f)},
                      0, 1, 0);
    }

private:
    using Bernstein = std::array<double, 4>;

    [[nodiscard]] bool search(const Bernstein& v, double first, double last, int depth) const
    {
        const auto [least, most] = std::ranges::minmax(v);
        if (least > 0 || most < 0) return false;
        if (least == 0 && most == 0) return is_inside(first) || is_inside(last); // in one plane
        if (depth == 40) return is_inside(0.5 * (first + last));
        const double ab = (v[0] + v[1]) / 2;
        const double bc = (v[1] + v[2]) / 2;
        const double cd = (v[2] + v[3]) / 2;
        const double abc = (ab + bc) / 2;
        const double bcd = (bc + cd) / 2;
        const double middle = (abc + bcd) / 2;
        const double half = 0.5 * (first + last);
        return search({v[0], ab, abc, middle}, first, half, depth + 1) ||
               search({middle, bcd, cd, v[3]}, half, last, depth + 1);
    }

    /// Whether the point, which is in the triangle's plane then, is in the triangle.
    [[nodiscard]] bool is_inside(double t) const
    {
        std::array<Vec3, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) corner[k] = begin_[k] + t * (end_[k] - begin_[k]);
        const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        if (normal.isZero(0)) return false;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 across = corner[k].cross(corner[(k + 1) % 3]);
            if (across.dot(normal) < 0) return false;
        }
        return true;
    }

    std::array<Vec3, 3> begin_; ///< the corners as the point sees them
    std::array<Vec3, 3> end_;
};

inline bool is_beside(const Box& box, const Vec3& from, const Vec3& to)
{
    return (from.cwiseMax(to).array() < box.lower.array()).any() ||
           (from.cwiseMin(to).array() > box.upper.array()).any();
}

/// What every vertex does, apart from the library.
class Vertices {
public:
    explicit Vertices(const TriangleMesh& mesh)
        : mesh_(&mesh), before_(mesh.positions().begin(), mesh.positions().end()), now_(before_),
          from_(before_), to_(before_), given_(before_)
    {}

    void deform(const std::vector<Vec3>& positions, double seconds)
    {
        from_ = given_;
        to_ = given_ = positions;
        seconds_ = seconds;
        ticks_ = 0;
    }

    void advance()
    {
        ++ticks_;
        const double passed = ticks_ * tick_seconds;
        const double part = passed < seconds_ * (1 - 1e-9) ? passed / seconds_ : 1;
        before_ = now_;
        for (std::size_t i = 0; i < now_.size(); ++i)
            now_[i] = part < 1 ? Vec3(from_[i] + part * (to_[i] - from_[i])) : to_[i];
    }

    [[nodiscard]] bool passes_while_changing(const Vec3& from, const Vec3& to) const
    {
        for (const TriangleCorners& corners : mesh_->triangles()) {
            const Triangle before = triangle(before_, corners);
            const Triangle now = triangle(now_, corners);
            Box box = bounding_box(before);
            for (const Vec3& corner : now.vertices) box.extend(corner);
            if (is_beside(box, from, to)) continue; // most of them
            if (is_degenerate(before) && is_degenerate(now)) continue;
            double nearer = 0; // the triangle comes no nearer than by this
            for (int k = 0; k < 3; ++k)
                nearer = std::max(nearer, (now[k] - before[k] - (to - from)).norm());
            const double begin = (closest_point(before, from).point - from).norm();
            if (begin > 2 * nearer) continue;
            if (Crossing(before, now, from, to).happens()) return true;
        }
        return false;
    }

    [[nodiscard]] bool passes_at_rest(std::span<const Vec3> path) const
    {
        for (const TriangleCorners& corners : mesh_->triangles()) {
            const Triangle now = triangle(now_, corners);
            const Box box = bounding_box(now);
            for (std::size_t i = 1; i < path.size(); ++i) {
                if (is_beside(box, path[i - 1], path[i]) || is_degenerate(now)) continue;
                if (segment_meets_triangle(path[i - 1], path[i], now)) return true;
            }
        }
        return false;
    }

    [[nodiscard]] double distance(const Vec3& p) const
    {
        double least = std::numeric_limits<double>::infinity();
        for (const TriangleCorners& corners : mesh_->triangles()) {
            const Triangle now = triangle(now_, corners);
            const Box box = bounding_box(now);
            const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
            if (gap.norm() >= least) continue;
            least = std::min(least, (closest_point(now, p).point - p).norm());
        }
        return least;
    }

private:
    [[nodiscard]] static Triangle triangle(const std::vector<Vec3>& positions,
                                           const TriangleCorners& corners)
    {
        return {{positions[corners[0]], positions[corners[1]], positions[corners[2]]}};
    }

    const TriangleMesh* mesh_;
    std::vector<Vec3> before_;
    std::vector<Vec3> now_;
    std::vector<Vec3> from_;
    std::vector<Vec3> to_;
    std::vector<Vec3> given_;
    double seconds_ = 0;
    int ticks_ = 0;
};

enum class Script { rest, stroke, poke };

inline Vec3 hand_at(Script script, double depth, double seconds)
{
    constexpr double turn = 2 * std::numbers::pi;
    // It comes from above.
    const double down = 0.03 - (0.03 + depth) * std::min(seconds / 0.1, 1.0);
    switch (script) {
    case Script::rest:
        break;
    case Script::stroke:
        return {0.06 * std::sin(turn * 0.9 * seconds), 0.05 * std::cos(turn * 0.6 * seconds), down};
    case Script::poke:
        return {0.013, -0.007, down + depth * (1 - std::cos(turn * 3 * seconds))};
    }
    return {0.013, -0.007, down};
}

/// A position in the frame of the scene's first object at the begin and the end of the last tick.
inline Vec3 local_before(const TouchScene& scene, const Vec3& p)
{
    return to_local(moving_surface(scene).object(ObjectId{0}).before, p);
}
inline std::vector<Vec3> local_now(const TouchScene& scene, std::span<const Vec3> path)
{
    std::vector<Vec3> result;
    for (const Vec3& p : path)
        result.push_back(to_local(moving_surface(scene).object(ObjectId{0}).now, p));
    return result;
}

/// What is wrong with a tick in which the only object of a scene moved and changed; "" if nothing.
inline std::string problem_of(const TouchScene& scene, const HapticRenderer& renderer,
                              const Vertices& vertices, const Vec3& before)
{
    const RenderTick& felt = renderer.last();
    const std::span<const Vec3> carried = parts_of(renderer).carried_path();
    if (!felt.force.allFinite()) return "force";
    if (!carried.empty() && felt.is_placed) {
        const auto path = local_now(scene, carried);
        if (vertices.passes_while_changing(local_before(scene, before), path.front()))
            return "passed while it changed";
        if (vertices.passes_at_rest(path)) return "passed as it settled";
        if (renderer.path().front() != carried.back()) return "another path";
    }
    if (!felt.is_placed) return "";
    if (vertices.passes_at_rest(local_now(scene, renderer.path()))) return "passed at rest";
    const double distance = vertices.distance(local_now(scene, {&felt.proxy, 1}).front());
    const double gap = distance - parts_of(renderer).proxy().radius();
    return gap < -1e-12 ? "too near by " + std::to_string(-gap) : "";
}

} // namespace proxima::testing
