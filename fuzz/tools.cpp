// A tool of any triangles that a hand drags among any others: its proxy keeps half the clearance from
// all of them, and passes none on its way.
#include "base/check.h"
#include "decoded_mesh.h"
#include "proxima/device.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/tool_renderer.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

namespace {

using namespace proxima;

/// Few of the decoded triangles, about as large as asked for and about the origin. Nothing where all are one point.
std::optional<TriangleMesh> small_mesh(fuzz::Bytes& bytes, std::size_t most, double size)
{
    const fuzz::PositionCode code(bytes);
    const auto shape = bytes.next() % 2 == 0 ? fuzz::Shape::closed : fuzz::Shape::soup;
    const TriangleMesh whole = fuzz::decode_mesh(bytes, code, shape);
    const Box box = bounding_box(whole);
    const double extent = box.extent().maxCoeff();
    if (!(extent > 1e-100) || !std::isfinite(extent)) return std::nullopt;
    std::vector<Vec3> positions;
    for (const Vec3& p : whole.positions())
        positions.emplace_back((p - box.center()) * (size / extent));
    const auto all = whole.triangles();
    const auto some = all.first(std::min(all.size(), most));
    return *make_triangle_mesh(std::move(positions), {some.begin(), some.end()});
}

/// Where the tool is on its way from one pose to another about one axis, which turns it by `angle` in all.
RigidTransform between(const RigidTransform& from, const RigidTransform& to, const Vec3& axis,
                       double angle, double part)
{
    return {Eigen::AngleAxisd(angle * part, axis).toRotationMatrix() * from.rotation,
            from.translation + part * (to.translation - from.translation)};
}

/// Whether the way is free, at sixteen places of it. The poses alone do not say which way round it goes, nor how often.
bool is_free_way(const MeshIndex& object, const MeshIndex& tool, const RigidTransform& from,
                 const RigidTransform& to)
{
    const Eigen::AngleAxisd turn(Mat3(to.rotation * from.rotation.transpose()));
    const auto is_free = [&](double angle) {
        for (int i = 1; i < 16; ++i) {
            if (meshes_intersect(object, tool, between(from, to, turn.axis(), angle, i / 16.0)))
                return false;
        }
        return true;
    };
    for (int whole_turns = -2; whole_turns <= 1; ++whole_turns) {
        if (is_free(turn.angle() + 2 * std::numbers::pi * whole_turns)) return true;
    }
    return false;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint8_t form = bytes.next();
    const auto tool_mesh = small_mesh(bytes, 1 + form % 8, 0.02);
    const auto object_mesh = small_mesh(bytes, 1 + form / 8 % 16, 0.06);
    if (!tool_mesh || !object_mesh) return 0;
    const MeshIndex tool = build_mesh_index(*tool_mesh).value();
    const MeshIndex object = build_mesh_index(*object_mesh).value();
    DeviceLimits device = *find_device("omega");
    device.max_torque = 0.1;
    ToolRenderOptions options;
    options.max_jump = 1;
    options.max_turn = 4;
    if (form >= 128) options.static_friction = options.dynamic_friction = 0;
    const std::array objects = {ToolObject{object, {}}};
    auto renderer = make_tool_renderer(tool, objects, {}, device, options);
    if (!renderer) return 0; // a mesh of triangles without an area, or too thin for the clearance
    DeviceState hand;
    hand.pose.translation = Vec3(0, 0, 0.1);
    for (int stroke = 0; stroke < 12 && bytes.left() > 0; ++stroke) {
        const Vec3 from = hand.pose.translation;
        const Vec3 to = Vec3(bytes.next_signed(), bytes.next_signed(), bytes.next_signed()) * 6e-4;
        const Vec3 axis = Vec3(bytes.next_signed(), bytes.next_signed(), 64).normalized();
        const double turn = bytes.next_signed() / 400.0;
        const int ticks = 1 + bytes.next() % 12;
        for (int i = 1; i <= ticks; ++i) {
            hand.pose.translation = from + (to - from) * i / ticks;
            hand.pose.rotation =
                Eigen::Quaterniond(Eigen::AngleAxisd(turn / ticks, axis) * hand.pose.rotation)
                    .normalized()
                    .toRotationMatrix();
            const ToolTick& tick = renderer->tick(hand, 1e-3);
            PROXIMA_CHECK(tick.force.allFinite() && tick.torque.allFinite());
            PROXIMA_CHECK(tick.proxy.translation.allFinite() && tick.proxy.rotation.allFinite());
            if (!tick.is_placed) continue;
            std::vector<RigidTransform> path(renderer->path().begin(), renderer->path().end());
            path.push_back(tick.proxy);
            for (std::size_t k = 0; k < path.size(); ++k) {
                const double distance = mesh_distance(object, tool, path[k]).value().distance;
                PROXIMA_CHECK_LE(0.49 * renderer->options().clearance, distance);
                if (k > 0) PROXIMA_CHECK(is_free_way(object, tool, path[k - 1], path[k]));
            }
        }
    }
    return 0;
}
