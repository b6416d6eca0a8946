#include "proxima/tool_renderer.h"

#include "base/text.h"
#include "geometry/pose_matrix.h"
#include "haptics/device/check_numbers.h"
#include "haptics/force/contact_force.h"
#include "haptics/scene/contact_body.h"
#include "haptics/scene/scene_views.h"
#include "haptics/scene/touch_access.h"
#include "haptics/tool/tool_guard.h"
#include "haptics/tool/tool_proxy.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// Squares of larger coordinates overflow.
constexpr double most_coordinate = 1e150;
/// Of clearances: a device farther away is a fault. The clearance would be lost in rounding.
constexpr double farthest_device = 0x1p40;
/// The clearance over the scene's size, at least: positions are rounded by 2^-52 of it.
constexpr double least_clearance = 0x1p-30;
/// An object that the tool holds up for longer lets it go, once the device is free.
constexpr double most_held_up_seconds = 0.5;
/// With less, a tick could not even prove short motions.
constexpr std::size_t least_work = 100;

/// A spring with a damper along its own stretch, which never makes it push.
Vec3 damped_spring(double stiffness, double damping, const Vec3& stretch, const Vec3& rate) noexcept
{
    const double length = stretch.norm();
    if (!(length > 0)) return Vec3::Zero();
    const Vec3 along = stretch / length;
    return std::max(stiffness * length + damping * rate.dot(along), 0.0) * along;
}

ToolRenderOptions limited(ToolRenderOptions options, const DeviceLimits& device,
                          double half_reach_metres)
{
    options.force = proxima::limited(options.force, device);
    if (options.torsional_stiffness == 0) {
        options.torsional_stiffness =
            options.force.stiffness * half_reach_metres * half_reach_metres;
    }
    return options;
}

ToolProxyOptions proxy_options(const ToolRenderOptions& options, const WorkspaceMap& map) noexcept
{
    const double length = std::sqrt(options.torsional_stiffness / options.force.stiffness);
    return {.clearance = options.clearance * map.units_per_metre,
            .turning_length = length * map.units_per_metre,
            .max_moves = options.max_moves,
            .max_work = options.max_work > 0 ? options.max_work : unlimited_work};
}

Status check_tool_settings(const WorkspaceMap& map, const DeviceLimits& device,
                           const ToolRenderOptions& options)
{
    for (const NamedNumber number : {NamedNumber{"units_per_metre", map.units_per_metre},
                                     NamedNumber{"max_force", device.max_force},
                                     NamedNumber{"max_stiffness", device.max_stiffness},
                                     NamedNumber{"stiffness", options.force.stiffness},
                                     NamedNumber{"clearance", options.clearance}}) {
        if (Status status = check_positive(number); !status) return status;
    }
    if (!map.center.allFinite()) {
        return fail(ErrorCode::invalid_argument, "the center of the workspace must be finite",
                    "center");
    }
    if (options.max_moves < 1 || options.max_moves > ToolProxy::most_moves) {
        return fail(
            ErrorCode::invalid_argument,
            concat("max_moves must be 1 to ", ToolProxy::most_moves, ", not ", options.max_moves),
            "max_moves");
    }
    if (options.max_work > 0 && options.max_work < least_work) {
        return fail(ErrorCode::invalid_argument,
                    concat("max_work must be at least ", least_work, ", or 0 for no bound, not ",
                           options.max_work),
                    "max_work");
    }
    if (options.dynamic_friction > options.static_friction) {
        return fail(ErrorCode::invalid_argument,
                    concat("dynamic_friction must be at most static_friction, ",
                           options.static_friction, ", not ", options.dynamic_friction),
                    "dynamic_friction");
    }
    return check_not_negative({{"max_damping", device.max_damping},
                               {"max_torque", device.max_torque},
                               {"damping", options.force.damping},
                               {"max_slew", options.force.max_slew},
                               {"start_seconds", options.force.start_seconds},
                               {"loss_seconds", options.force.loss_seconds},
                               {"torsional_stiffness", options.torsional_stiffness},
                               {"torsional_damping", options.torsional_damping},
                               {"static_friction", options.static_friction},
                               {"dynamic_friction", options.dynamic_friction},
                               {"max_torque_slew", options.max_torque_slew},
                               {"max_jump", options.max_jump},
                               {"max_turn", options.max_turn}});
}

/// Error where the scene is so large that the clearance is lost in rounding.
Status check_clearance(const ToolProxyOptions& options, const RigidBody& tool,
                       std::span<const SeenObject> objects, double scene_size)
{
    double size = std::max(tool.features.reach(), scene_size);
    for (const SeenObject& object : objects) {
        const Box& box = object.body.features.bounds();
        size = std::max({size, object.pose.translation.norm(), box.lower.norm(), box.upper.norm()});
    }
    if (!(size < most_coordinate)) {
        return fail(ErrorCode::invalid_mesh, concat("the meshes must lie within ", most_coordinate,
                                                    " of the origin: scale or move them"));
    }
    if (options.clearance >= least_clearance * size) return {};
    return fail(ErrorCode::invalid_argument,
                concat("the clearance is ", options.clearance,
                       " in the model's unit, and coordinates of ", size, " need at least ",
                       least_clearance * size,
                       ": give a larger one, or move the meshes to the origin"),
                "clearance");
}

/// An object's own friction, or that of the options.
Friction friction_of(const std::optional<SurfaceMaterial>& material,
                     const ToolRenderOptions& options) noexcept
{
    if (material) return {material->static_friction, material->dynamic_friction};
    return {options.static_friction, options.dynamic_friction};
}

/// An index of the body's triangles where they are: that of a refit holds the body that was built first.
Result<MeshIndex> index_of(const ContactBody& body)
{
    return body.is_refit() ? build_mesh_index(body.mesh()) : body.mesh_index();
}

bool is_usable(const RigidTransform& pose, double farthest) noexcept
{
    return (pose.translation.array().abs() <= farthest).all() &&
           (pose.rotation.transpose() * pose.rotation - Mat3::Identity()).norm() <
               nearly_rigid_tolerance &&
           pose.rotation.determinant() > 0;
}

} // namespace

/// The implementation of ToolRenderer: proxy, springs and guards. With a view of a scene each tick moves
/// its objects.
class PROXIMA_HIDDEN ToolSurfaceRenderer {
public:
    ToolSurfaceRenderer(RigidBody tool, std::vector<SeenObject> objects, SceneView view,
                        const WorkspaceMap& map, const DeviceLimits& device,
                        const ToolRenderOptions& options)
        : view_(std::move(view)), map_(map), options_(options),
          proxy_(std::move(tool), std::move(objects), proxy_options(options, map)),
          guard_(options, device), gives_torque_(device.max_torque > 0)
    {}

    /// \pre check_tool_settings() holds, and the objects' poses are rigid
    [[nodiscard]] static Result<ToolRenderer>
    make(const MeshIndex& tool, std::span<const ToolObject> objects, SceneView view,
         const WorkspaceMap& map, const DeviceLimits& device, const ToolRenderOptions& options);

    [[nodiscard]] const ToolRenderOptions& options() const noexcept { return options_; }
    [[nodiscard]] const WorkspaceMap& map() const noexcept { return map_; }
    [[nodiscard]] const ToolTick& last() const noexcept { return tick_; }
    [[nodiscard]] std::span<const RigidTransform> path() const noexcept { return proxy_.path(); }

    [[nodiscard]] const ToolGuard& guard() const noexcept { return guard_; }
    [[nodiscard]] static const ToolSurfaceRenderer& of(const ToolRenderer& renderer) noexcept
    {
        return *renderer.renderer_;
    }

    void reset() noexcept
    {
        tick_ = {};
        has_device_ = false;
        is_placed_ = false;
        lets_go_ = false;
        held_up_seconds_ = 0;
        guard_.reset();
    }

    const ToolTick& tick(const DeviceState& state, double seconds) noexcept
    {
        tick_.condition = state.condition;
        if (view_ != nullptr) advance_scene(seconds);
        accept(state);
        if (!has_device_) {
            tick_.is_placed = false;
            return tick_;
        }
        const RigidTransform device = {tick_.device.rotation,
                                       map_.to_model(tick_.device.translation)};
        if (lets_go_ && guard_.ramp() == 0) is_placed_ = false;
        const bool was_placed = std::exchange(is_placed_, is_placed_ || proxy_.place(device));
        if (is_placed_) proxy_.follow(device);
        const bool is_held_up = is_placed_ && proxy_.is_held_up();
        held_up_seconds_ = is_held_up ? held_up_seconds_ + seconds : 0;
        const bool is_stuck =
            proxy_.end() == ToolEnd::overloaded || held_up_seconds_ > most_held_up_seconds;
        lets_go_ = is_placed_ && is_stuck && proxy_.is_free(device);
        write_proxy(device);
        pull(device, seconds, was_placed);
        return tick_;
    }

private:
    /// Objects move on, and have the friction of their materials.
    void advance_scene(double seconds) noexcept
    {
        advanced_ = view_->advance(seconds).seconds;
        for (std::uint32_t at = 0; at < view_->object_count(); ++at) {
            const auto material = view_->material(scene_triangle(ObjectId{at}, TriangleId{0}));
            proxy_.set_object(at, view_->object(ObjectId{at}).now, friction_of(material, options_));
        }
    }

    /// Takes over the device's pose, or keeps the last one.
    void accept(const DeviceState& state) noexcept
    {
        tick_.fault = InputFault::none;
        travel_ = {};
        RigidTransform pose = state.pose;
        const double farthest = farthest_device * options_.clearance * map_.units_per_metre;
        if (!is_usable({pose.rotation, map_.to_model(pose.translation)}, farthest)) {
            tick_.fault = InputFault::not_finite;
            return;
        }
        pose.rotation = Eigen::Quaterniond(pose.rotation).normalized().toRotationMatrix();
        if (has_device_) {
            const Twist step = twist_between(tick_.device, pose);
            if (!(step.linear.norm() <= options_.max_jump) ||
                !(step.angular.norm() <= options_.max_turn)) {
                tick_.fault = InputFault::jumped;
            } else {
                travel_ = step;
            }
        }
        tick_.device = pose;
        has_device_ = true;
    }

    void write_proxy(const RigidTransform& device) noexcept
    {
        tick_.is_placed = is_placed_;
        tick_.proxy = is_placed_ ? proxy_.pose() : device;
        tick_.hold = is_placed_ ? proxy_.hold() : Hold::free;
        tick_.end = proxy_.end();
        tick_.moves = proxy_.work().moves;
        tick_.near_triangles = proxy_.work().pairs;
        tick_.work = proxy_.work().spent;
        tick_.contact_count = proxy_.contacts().size();
        const double newtons = options_.force.stiffness / map_.units_per_metre;
        for (std::size_t i = 0; i < tick_.contact_count; ++i) {
            const HeldContact& held = proxy_.contacts()[i];
            tick_.contacts[i] = {
                held.contact.scene_point, held.contact.normal, held.object,
                held.scene_triangle,      held.tool_triangle,  newtons * held.pressure};
        }
    }

    /// The springs between device and proxy, and their guards.
    void pull(const RigidTransform& device, double seconds, bool was_placed) noexcept
    {
        Twist stretch = twist_between(device, tick_.proxy);
        stretch.linear /= map_.units_per_metre;
        const bool has_rate = was_placed && tick_.fault == InputFault::none;
        const Vec3 rate =
            has_rate ? Vec3((stretch.linear - stretch_.linear) / seconds) : Vec3(Vec3::Zero());
        const Vec3 turn_rate =
            has_rate ? Vec3((stretch.angular - stretch_.angular) / seconds) : Vec3(Vec3::Zero());
        stretch_ = stretch;
        tick_.spring_force =
            damped_spring(options_.force.stiffness, options_.force.damping, stretch.linear, rate);
        tick_.spring_torque = damped_spring(options_.torsional_stiffness,
                                            options_.torsional_damping, stretch.angular, turn_rate);
        const bool available = tick_.fault != InputFault::not_finite &&
                               tick_.condition == InputCondition::well && !lets_go_;
        const Patch patch = available ? Patch::available : Patch::lost;
        // The proxy may still be on its way after a jump: the force rises from the next tick on.
        ToolPull pull;
        pull.travel = travel_;
        if (options_.guard != Guard::off) pull.ground = ground_travel();
        pull.ground_seconds = advanced_;
        pull.jumped = tick_.fault == InputFault::jumped;
        if (!pull.jumped) {
            pull.spring.force = options_.force.stiffness * stretch.linear;
            pull.whole.force = tick_.spring_force;
        }
        if (!pull.jumped && gives_torque_) {
            pull.spring.torque = options_.torsional_stiffness * stretch.angular;
            pull.whole.torque = tick_.spring_torque;
        }
        const Wrench given = guard_.pass(pull, seconds, patch);
        tick_.force = given.force;
        tick_.torque = given.torque;
        tick_.force_scale = guard_.ramp();
    }

    /// How far the touched objects moved the tool in this tick, a mean by pressure; none: it touches
    /// none that can move.
    [[nodiscard]] std::optional<Twist> ground_travel() const noexcept
    {
        Twist sum;
        if (view_ == nullptr) return std::nullopt;
        double pressures = 0;
        const Vec3& tip = tick_.proxy.translation;
        for (const HeldContact& held : proxy_.contacts()) {
            const SceneObject object = view_->object(ObjectId{held.object});
            const Vec3 before = object.before(to_local(object.now, tip));
            sum.linear += held.pressure / map_.units_per_metre * (tip - before);
            sum.angular += held.pressure * twist_between(object.before, object.now).angular;
            pressures += held.pressure;
        }
        return pressures > 0 ? std::optional(sum.scaled(1 / pressures)) : std::nullopt;
    }

    SceneView view_; ///< null without a scene
    WorkspaceMap map_;
    ToolRenderOptions options_;
    ToolProxy proxy_;
    ToolGuard guard_;
    ToolTick tick_;
    Twist stretch_;              ///< of the last tick, in metres
    Twist travel_;               ///< of the device in this tick, m and rad
    double advanced_ = 0;        ///< s: by which the scene moved on in this tick; 0 without one
    double held_up_seconds_ = 0; ///< for which an object was behind and did not come on
    bool gives_torque_;
    bool has_device_ = false;
    bool is_placed_ = false;
    /// A crowd of triangles holds the proxy, or an object does not come on, while the device is free: the
    /// force fades, and then the tool is placed anew.
    bool lets_go_ = false;
};

ToolRenderer::ToolRenderer(std::unique_ptr<ToolSurfaceRenderer> renderer) noexcept
    : renderer_(std::move(renderer))
{}

ToolRenderer::ToolRenderer(ToolRenderer&& other) noexcept = default;
ToolRenderer& ToolRenderer::operator=(ToolRenderer&& other) noexcept = default;
ToolRenderer::~ToolRenderer() = default;

const ToolRenderOptions& ToolRenderer::options() const noexcept
{
    return renderer_->options();
}

const WorkspaceMap& ToolRenderer::map() const noexcept
{
    return renderer_->map();
}

const ToolTick& ToolRenderer::tick(const DeviceState& state, double seconds) noexcept
{
    return renderer_->tick(state, seconds);
}

void ToolRenderer::reset() noexcept
{
    renderer_->reset();
}

const ToolTick& ToolRenderer::last() const noexcept
{
    return renderer_->last();
}

std::span<const RigidTransform> ToolRenderer::path() const noexcept
{
    return renderer_->path();
}

const ToolGuard& guard_of(const ToolRenderer& renderer) noexcept
{
    return ToolSurfaceRenderer::of(renderer).guard();
}

Result<ToolRenderer> ToolSurfaceRenderer::make(const MeshIndex& tool,
                                               std::span<const ToolObject> objects, SceneView view,
                                               const WorkspaceMap& map, const DeviceLimits& device,
                                               const ToolRenderOptions& options)
{
    auto tool_body = RigidBody::build(tool);
    if (!tool_body) return tl::unexpected(tool_body.error());
    std::vector<SeenObject> seen;
    for (const ToolObject& object : objects) {
        auto body = RigidBody::build(object.index);
        if (!body) return tl::unexpected(body.error());
        seen.push_back({.body = std::move(*body),
                        .pose = object.pose,
                        .goal = object.pose,
                        .friction = friction_of(std::nullopt, options)});
    }
    const double half_reach = 0.5 * tool_body->features.reach() / map.units_per_metre;
    const ToolRenderOptions used = limited(options, device, half_reach);
    const double scene_size = view != nullptr ? view->scale().reach : 0;
    if (Status status = check_clearance(proxy_options(used, map), *tool_body, seen, scene_size);
        !status)
        return tl::unexpected(status.error());
    return ToolRenderer(std::make_unique<ToolSurfaceRenderer>(
        std::move(*tool_body), std::move(seen), std::move(view), map, device, used));
}

Result<ToolRenderer> make_tool_renderer(const MeshIndex& tool, std::span<const ToolObject> objects,
                                        const WorkspaceMap& map, const DeviceLimits& device,
                                        const ToolRenderOptions& options)
{
    if (Status status = check_tool_settings(map, device, options); !status)
        return tl::unexpected(status.error());
    std::vector<ToolObject> placed(objects.begin(), objects.end());
    for (ToolObject& object : placed) {
        const auto pose = make_rigid_transform(pose_matrix(object.pose));
        if (!pose || !is_usable(*pose, most_coordinate)) {
            return fail(ErrorCode::invalid_argument, "the pose of an object must be rigid",
                        "objects");
        }
        object.pose = *pose;
    }
    return ToolSurfaceRenderer::make(tool, placed, nullptr, map, device, options);
}

Result<ToolRenderer> make_tool_renderer(const MeshIndex& tool, TouchScene& scene,
                                        const WorkspaceMap& map, const DeviceLimits& device,
                                        const ToolRenderOptions& options)
{
    if (Status status = check_tool_settings(map, device, options); !status)
        return tl::unexpected(status.error());
    SceneViews& views = scene_views(scene);
    auto view = views.take(AddedObjects::unfelt);
    if (!view) return tl::unexpected(view.error());
    std::vector<ToolObject> objects;
    for (std::uint32_t at = 0; at < (*view)->object_count(); ++at) {
        auto index = index_of(*views.input().body(ObjectId{at}));
        if (!index) return tl::unexpected(index.error());
        objects.push_back({*index, (*view)->object(ObjectId{at}).now});
    }
    return ToolSurfaceRenderer::make(tool, objects, std::move(*view), map, device, options);
}

} // namespace proxima
