// A tool that is led through poses, tick by tick, for tests.
#pragma once

#include "haptics/servo_tick.h"
#include "octree/small_meshes.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/tool_renderer.h"

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

namespace proxima::testing {

/// A device whose limits no test reaches.
inline DeviceLimits strong_device()
{
    return {.name = "strong",
            .max_force = 1e6,
            .max_stiffness = 1e4,
            .max_damping = 0,
            .workspace_radius = 1,
            .max_torque = 1e6};
}

/// Springs alone: no ramps, no damping, no friction and no limits.
inline ToolRenderOptions plain_springs()
{
    ToolRenderOptions options;
    options.force = {
        .stiffness = 500, .damping = 0, .max_slew = 1e12, .start_seconds = 0, .loss_seconds = 0.05};
    options.torsional_stiffness = 0.5;
    options.static_friction = options.dynamic_friction = 0;
    options.max_torque_slew = 1e12;
    options.guard = Guard::off;
    return options;
}

inline ToolRenderOptions springs_with_friction(double fixed, double sliding)
{
    ToolRenderOptions options = plain_springs();
    options.static_friction = fixed;
    options.dynamic_friction = sliding;
    return options;
}

inline RigidTransform pose_at(const Vec3& position, const Vec3& turn = Vec3::Zero())
{
    const double angle = turn.norm();
    RigidTransform pose = {Mat3::Identity(), position};
    if (angle > 0) pose.rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    return pose;
}

/// Three numbers from -1 to 1, drawn one after the other: compilers differ in the order of arguments.
inline Vec3 random_vector(std::mt19937& random)
{
    std::uniform_real_distribution<double> unit(-1, 1);
    const double x = unit(random);
    const double y = unit(random);
    return {x, y, unit(random)};
}

/// Two slopes of 45 degrees that meet along the y axis.
inline TriangleMesh groove_mesh()
{
    return mesh_of({{0, -0.1, 0},
                    {0, 0.1, 0},
                    {0.1, -0.1, 0.1},
                    {0.1, 0.1, 0.1},
                    {-0.1, -0.1, 0.1},
                    {-0.1, 0.1, 0.1}},
                   {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}});
}

/// A box of the given half extents about a center.
inline TriangleMesh box_mesh(const Vec3& half, const Vec3& center = Vec3::Zero())
{
    return moved(cube_mesh(Vec3::Zero(), 1.0),
                 [&](const Vec3& p) { return Vec3(center + half.cwiseProduct(p)); });
}

/// A block from z = -0.03 to `top` with a square hole through it, `room` on each side of a square peg of
/// half width `side`.
inline TriangleMesh block_with_hole(double side, double room, double top)
{
    const double hole = side + room;
    const double outer = 0.03;
    std::vector<Vec3> positions;
    for (const double size : {hole, outer}) {
        for (const double z : {-0.03, top}) {
            for (const auto& [x, y] :
                 {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
                positions.emplace_back(size * x, size * y, z);
        }
    }
    std::vector<TriangleCorners> triangles;
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
    };
    for (std::uint32_t k = 0; k < 4; ++k) {
        const std::uint32_t next = (k + 1) % 4;
        quad(k, 4 + k, 4 + next, next);           // the hole's wall, seen from inside
        quad(8 + k, 8 + next, 12 + next, 12 + k); // the outer wall
        quad(4 + k, 12 + k, 12 + next, 4 + next); // the top
        quad(k, next, 8 + next, 8 + k);           // the bottom
    }
    return mesh_of(positions, triangles);
}

inline MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

/// A renderer and its scene. Units are metres.
class ToolBench {
public:
    ToolBench(const TriangleMesh& tool, std::vector<ToolObject> objects,
              const ToolRenderOptions& options = plain_springs())
        : tool_(index_of(tool)), objects_(std::move(objects)),
          renderer_(
              make_tool_renderer(tool_, objects_, WorkspaceMap{}, strong_device(), options).value())
    {}

    const ToolTick& tick(const RigidTransform& device)
    {
        DeviceState state;
        state.pose = device;
        return renderer_.tick(state, tick_seconds);
    }

    /// Leads the device there within so many ticks, and holds it there.
    const ToolTick& lead(const RigidTransform& goal, int ticks, int rest = 100)
    {
        const Vec3 from = at_.translation;
        const Eigen::AngleAxisd turn(Mat3(goal.rotation * at_.rotation.transpose()));
        const Mat3 rotation = at_.rotation;
        for (int i = 1; i <= ticks; ++i) {
            const double part = i / static_cast<double>(ticks);
            at_.translation = from + part * (goal.translation - from);
            at_.rotation =
                Eigen::AngleAxisd(part * turn.angle(), turn.axis()).toRotationMatrix() * rotation;
            tick(at_);
        }
        at_ = goal;
        for (int i = 0; i < rest; ++i) tick(at_);
        return renderer_.last();
    }
    void start(const RigidTransform& pose)
    {
        at_ = pose;
        tick(pose);
    }

    /// Whether the tool meets an object where the proxy is.
    [[nodiscard]] bool meets() const
    {
        const RigidTransform& proxy = renderer_.last().proxy;
        for (const ToolObject& object : objects_) {
            const Mat3 back = object.pose.rotation.transpose();
            const RigidTransform relative = {back * proxy.rotation,
                                             back * (proxy.translation - object.pose.translation)};
            if (meshes_intersect(object.index, tool_, relative)) return true;
        }
        return false;
    }

    [[nodiscard]] const ToolRenderer& renderer() const { return renderer_; }
    [[nodiscard]] const RigidTransform& device() const { return at_; }

private:
    MeshIndex tool_;
    std::vector<ToolObject> objects_;
    ToolRenderer renderer_;
    RigidTransform at_;
};

} // namespace proxima::testing
