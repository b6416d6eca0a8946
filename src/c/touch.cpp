// Touch by the C interface.
#include "c/handles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace {

using namespace proxima;
using namespace proxima::c;

static_assert(static_cast<int>(Hold::sliding) == 1 && static_cast<int>(Hold::sticking) == 2);
static_assert(static_cast<int>(InputFault::not_finite) == 1 &&
              static_cast<int>(InputFault::jumped) == 2);

std::optional<SurfaceMaterial> material_of(const proxima_material* material)
{
    if (material == nullptr) return {};
    return SurfaceMaterial{material->stiffness, material->damping, material->static_friction,
                           material->dynamic_friction};
}

RenderOptions options_of(const proxima_render_options& options)
{
    RenderOptions own;
    own.force.stiffness = options.stiffness;
    own.force.damping = options.damping;
    own.proxy_radius = options.proxy_radius;
    own.static_friction = options.static_friction;
    own.dynamic_friction = options.dynamic_friction;
    own.guard = static_cast<Guard>(options.guard);
    return own;
}

bool is_box(const double* lower, const double* upper)
{
    const Box box{vector_of(lower), vector_of(upper)};
    if (!box.empty() && box.lower.allFinite() && box.upper.allFinite()) return true;
    refused("the box is empty or not finite");
    return false;
}

bool is_object(const proxima_scene* scene, std::uint32_t object)
{
    if (object < scene->scene->object_count()) return true;
    refused("the scene has no object of that number");
    return false;
}

proxima_contact converted(const ContactPoint& contact)
{
    proxima_contact point = {};
    copy_to(point.position, contact.position);
    copy_to(point.normal, contact.normal);
    point.pressure = contact.pressure;
    point.object = to_index(object_of(contact.triangle));
    point.triangle = to_index(triangle_of(contact.triangle));
    return point;
}

void convert(const RenderTick& felt, proxima_tick& tick)
{
    copy_to(tick.force, felt.force);
    copy_to(tick.proxy, felt.proxy);
    copy_to(tick.anchor, felt.anchor);
    copy_to(tick.normal, felt.normal);
    tick.depth = felt.depth;
    tick.holds = static_cast<std::int32_t>(felt.hold);
    tick.is_placed = felt.is_placed ? 1 : 0;
    tick.fault = static_cast<std::int32_t>(felt.fault);
    tick.is_squeezed = felt.squeezed ? 1 : 0;
    tick.contact_count = static_cast<std::uint32_t>(felt.contact_count);
    for (std::size_t i = 0; i < felt.contacts.size(); ++i)
        tick.contacts[i] = i < felt.contact_count ? converted(felt.contacts[i]) : proxima_contact{};
}

} // namespace

proxima_status proxima_body_create(const proxima_mesh* mesh, const proxima_material* material,
                                   proxima_body** body)
{
    if (any_null(mesh, body)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<TouchBody> made =
            build_touch_body(mesh->mesh, {.material = material_of(material)});
        if (!made) return failed(made.error());
        *body = new proxima_body{*made};
        return PROXIMA_OK;
    });
}

void proxima_body_destroy(proxima_body* body)
{
    delete body;
}

proxima_status proxima_scene_create(const double lower[3], const double upper[3],
                                    proxima_scene** scene)
{
    if (any_null(lower, upper, scene) || !is_box(lower, upper)) return PROXIMA_INVALID_ARGUMENT;
    const Vec3 extent = vector_of(upper) - vector_of(lower);
    if (!extent.allFinite() || !(extent.array() > 0).all())
        return refused("the box is flat, or its extent is not finite");
    return guarded([&] {
        *scene = new proxima_scene{
            std::make_shared<TouchScene>(Box{vector_of(lower), vector_of(upper)})};
        return PROXIMA_OK;
    });
}

void proxima_scene_destroy(proxima_scene* scene)
{
    delete scene;
}

proxima_status proxima_scene_add(proxima_scene* scene, const proxima_body* body,
                                 const double pose[12], uint32_t* object)
{
    if (any_null(scene, body, object)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<RigidTransform> place = pose_of(pose);
        if (!place) return failed(place.error());
        const Result<ObjectId> added = scene->scene->add(body->body, *place);
        if (!added) return failed(added.error());
        *object = to_index(*added);
        return PROXIMA_OK;
    });
}

proxima_status proxima_scene_move(proxima_scene* scene, uint32_t object,
                                  const proxima_motion* motion)
{
    if (any_null(scene, motion) || !is_object(scene, object)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] {
        const Result<RigidTransform> pose = pose_of(motion->pose);
        if (!pose) return failed(pose.error());
        return status_of(
            scene->scene->move(ObjectId{object}, {.pose = *pose,
                                                  .seconds = motion->seconds,
                                                  .velocity = vector_of(motion->velocity),
                                                  .spin = vector_of(motion->spin),
                                                  .coast_seconds = motion->coast_seconds}));
    });
}

proxima_status proxima_scene_exchange(proxima_scene* scene, uint32_t object,
                                      const proxima_body* body)
{
    if (any_null(scene, body) || !is_object(scene, object)) return PROXIMA_INVALID_ARGUMENT;
    return guarded([&] { return status_of(scene->scene->exchange(ObjectId{object}, body->body)); });
}

proxima_status proxima_device_limits_of(const char* name, proxima_device_limits* limits)
{
    if (any_null(name, limits)) return PROXIMA_INVALID_ARGUMENT;
    const std::optional<DeviceLimits> found = find_device(name);
    if (!found) return refused("no known device: touch, omni, desktop, falcon, omega, delta");
    *limits = {found->max_force, found->max_stiffness, found->max_damping, found->workspace_radius};
    return PROXIMA_OK;
}

proxima_status proxima_fit_workspace(const double lower[3], const double upper[3],
                                     double workspace_radius, proxima_workspace* workspace)
{
    if (any_null(lower, upper, workspace) || !is_box(lower, upper)) return PROXIMA_INVALID_ARGUMENT;
    if (!(workspace_radius > 0) || !std::isfinite(workspace_radius))
        return refused("the workspace's radius is not above 0 and finite");
    const WorkspaceMap map = fit_workspace({vector_of(lower), vector_of(upper)}, workspace_radius);
    if (!std::isfinite(map.units_per_metre))
        return refused("the box is too large for the workspace: scale it down");
    workspace->units_per_metre = map.units_per_metre;
    copy_to(workspace->center, map.center);
    return PROXIMA_OK;
}

void proxima_render_options_default(proxima_render_options* options)
{
    if (options == nullptr) return;
    const RenderOptions own;
    *options = {own.force.stiffness, own.force.damping,    own.proxy_radius,
                own.static_friction, own.dynamic_friction, static_cast<std::int32_t>(own.guard)};
}

proxima_status proxima_renderer_create(proxima_scene* scene, const proxima_workspace* workspace,
                                       const proxima_device_limits* limits,
                                       const proxima_render_options* options,
                                       proxima_renderer** renderer)
{
    if (any_null(scene, workspace, limits, renderer)) return PROXIMA_INVALID_ARGUMENT;
    proxima_render_options wanted;
    proxima_render_options_default(&wanted);
    if (options != nullptr) wanted = *options;
    if (wanted.guard < PROXIMA_GUARD_OFF || wanted.guard > PROXIMA_GUARD_ON)
        return refused("guard: none of PROXIMA_GUARD_OFF, PROXIMA_GUARD_OBSERVE, PROXIMA_GUARD_ON");
    return guarded([&] {
        DeviceLimits device;
        device.max_force = limits->max_force;
        device.max_stiffness = limits->max_stiffness;
        device.max_damping = limits->max_damping;
        device.workspace_radius = limits->workspace_radius;
        Result<HapticRenderer> made = make_haptic_renderer(
            *scene->scene, {workspace->units_per_metre, vector_of(workspace->center)}, device,
            options_of(wanted));
        if (!made) return failed(made.error());
        *renderer = new proxima_renderer{scene->scene, std::move(*made)};
        return PROXIMA_OK;
    });
}

void proxima_renderer_destroy(proxima_renderer* renderer)
{
    delete renderer;
}

proxima_status proxima_renderer_tick(proxima_renderer* renderer, const double position[3],
                                     const double velocity[3], double seconds, proxima_tick* tick)
{
    if (any_null(renderer, position, tick)) return PROXIMA_INVALID_ARGUMENT;
    if (!(seconds > 0) || !std::isfinite(seconds))
        return refused("seconds: not above 0 and finite");
    DeviceState state;
    state.pose.translation = vector_of(position);
    if (velocity != nullptr) state.velocity = vector_of(velocity);
    convert(renderer->renderer.tick(state, seconds), *tick);
    return PROXIMA_OK;
}

proxima_status proxima_renderer_reset(proxima_renderer* renderer)
{
    if (any_null(renderer)) return PROXIMA_INVALID_ARGUMENT;
    renderer->renderer.reset();
    return PROXIMA_OK;
}
