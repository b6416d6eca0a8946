#include "haptics/loop/recording_rows.h"

#include "base/text.h"
#include "geometry/pose_matrix.h"
#include "haptics/loop/recorded_numbers.h"

#include <algorithm>
#include <string>

namespace proxima {

SettingNumbers recording_row(const RecordingSettings& settings)
{
    const RenderOptions& render = settings.render;
    const Vec3& center = settings.map.center;
    return {settings.tick_seconds,
            settings.map.units_per_metre,
            {center.x(), center.y(), center.z()},
            render.force.stiffness,
            render.force.damping,
            render.force.max_slew,
            render.force.start_seconds,
            render.force.loss_seconds,
            render.proxy_radius,
            render.static_friction,
            render.dynamic_friction,
            guard_number(render.guard),
            render.max_jump,
            settings.max_force,
            settings.max_stiffness,
            settings.max_damping,
            render.shading == ForceShading::on ? 1.0 : 0.0};
}

RecordingSettings settings_of(const SettingNumbers& numbers, std::uint64_t fingerprint)
{
    RecordingSettings settings;
    settings.mesh_fingerprint = fingerprint;
    settings.tick_seconds = numbers.tick_seconds;
    settings.map = {numbers.units_per_metre,
                    Vec3(numbers.center[0], numbers.center[1], numbers.center[2])};
    settings.render = {.force = {.stiffness = numbers.stiffness,
                                 .damping = numbers.damping,
                                 .max_slew = numbers.max_slew,
                                 .start_seconds = numbers.start_seconds,
                                 .loss_seconds = numbers.loss_seconds},
                       .proxy_radius = numbers.proxy_radius,
                       .static_friction = numbers.static_friction,
                       .dynamic_friction = numbers.dynamic_friction,
                       .guard = guard_of_number(numbers.guard),
                       .max_jump = numbers.max_jump,
                       .shading = numbers.shading != 0 ? ForceShading::on : ForceShading::off};
    settings.max_force = numbers.max_force;
    settings.max_stiffness = numbers.max_stiffness;
    settings.max_damping = numbers.max_damping;
    return settings;
}

MessageNumbers recording_row(const SceneMessage& message)
{
    MessageNumbers result{};
    result.tick = message.tick;
    result.object = to_index(message.object);
    result.parts = (message.has_motion ? 1U : 0U) | (message.has_material ? 2U : 0U);
    const ObjectMotion& motion = message.motion;
    std::ranges::copy(pose_matrix(motion.pose), result.pose);
    result.seconds = motion.seconds;
    for (int axis = 0; axis < 3; ++axis) {
        result.velocity[axis] = motion.velocity[axis];
        result.spin[axis] = motion.spin[axis];
    }
    result.coast_seconds = motion.coast_seconds;
    result.stiffness = message.material.stiffness;
    result.damping = message.material.damping;
    result.static_friction = message.material.static_friction;
    result.dynamic_friction = message.material.dynamic_friction;
    result.material_seconds = message.material_seconds;
    return result;
}

ObjectNumbers recording_row(const ScriptedObject& object)
{
    ObjectNumbers result{};
    std::ranges::copy(pose_matrix(object.pose), result.pose);
    for (int axis = 0; axis < 3; ++axis) result.along[axis] = object.script.along[axis];
    result.kind = static_cast<double>(object.script.kind);
    result.angle = object.script.angle;
    result.seconds = object.script.seconds;
    if (!object.material) return result;
    result.has_material = 1;
    result.stiffness = object.material->stiffness;
    result.damping = object.material->damping;
    result.static_friction = object.material->static_friction;
    result.dynamic_friction = object.material->dynamic_friction;
    return result;
}

Result<ScriptedObject> object_of(const ObjectNumbers& numbers, std::uint64_t fingerprint,
                                 std::size_t number)
{
    const std::string of = concat("object ", number, ": ");
    const auto pose = make_rigid_transform(numbers.pose);
    if (!pose) {
        return fail(ErrorCode::malformed_file,
                    concat(of, "pose: ", pose.error().message, ": record the session again"));
    }
    constexpr auto last_kind = static_cast<int>(ObjectMotionKind::swing);
    if (Status status = check_choice(of + "kind of motion", numbers.kind, last_kind); !status)
        return tl::unexpected(status.error());
    if (Status status = check_choice(of + "has_material", numbers.has_material, 1); !status)
        return tl::unexpected(status.error());
    ScriptedObject object;
    object.mesh_fingerprint = fingerprint;
    object.pose = *pose;
    object.script.kind = static_cast<ObjectMotionKind>(numbers.kind);
    object.script.along = Vec3(numbers.along[0], numbers.along[1], numbers.along[2]);
    object.script.angle = numbers.angle;
    object.script.seconds = numbers.seconds;
    if (numbers.has_material != 0) {
        object.material = SurfaceMaterial{.stiffness = numbers.stiffness,
                                          .damping = numbers.damping,
                                          .static_friction = numbers.static_friction,
                                          .dynamic_friction = numbers.dynamic_friction};
    }
    return object;
}

TextureNumbers recording_row(const std::optional<SurfaceTexture>& given) noexcept
{
    const SurfaceTexture texture = given.value_or(SurfaceTexture{});
    const Bump& bump = texture.bump;
    return {given ? 1.0 : 0.0,
            static_cast<double>(bump.shape),
            bump.amplitude,
            bump.wavelength,
            {bump.direction.x(), bump.direction.y(), bump.direction.z()},
            texture.viscosity,
            texture.stick_slip.stiffness,
            texture.stick_slip.max_force,
            texture.tap.gain,
            texture.tap.frequency,
            texture.tap.decay};
}

SurfaceTexture texture_of(const TextureNumbers& numbers) noexcept
{
    return {
        .bump = {.shape = static_cast<BumpShape>(numbers.shape),
                 .amplitude = numbers.amplitude,
                 .wavelength = numbers.wavelength,
                 .direction =
                     Vec3(numbers.direction[0], numbers.direction[1], numbers.direction[2])},
        .viscosity = numbers.viscosity,
        .stick_slip = {.stiffness = numbers.stick_stiffness, .max_force = numbers.stick_max_force},
        .tap = {.gain = numbers.tap_gain,
                .frequency = numbers.tap_frequency,
                .decay = numbers.tap_decay}};
}

Result<SceneMessage> message_of(const MessageNumbers& numbers, std::size_t number)
{
    const std::string of = concat("message ", number, ": ");
    const auto pose = make_rigid_transform(numbers.pose);
    if (!pose) {
        return fail(ErrorCode::malformed_file,
                    concat(of, "pose: ", pose.error().message, ": record the session again"));
    }
    if (numbers.parts < 1 || numbers.parts > 3) {
        return fail(ErrorCode::malformed_file,
                    concat(of, "parts is ", numbers.parts,
                           " and must be 1 to 3: record the session again"));
    }
    SceneMessage message;
    message.tick = numbers.tick;
    message.object = ObjectId{numbers.object};
    message.has_motion = (numbers.parts & 1U) != 0;
    message.has_material = (numbers.parts & 2U) != 0;
    message.motion = {.pose = *pose,
                      .seconds = numbers.seconds,
                      .velocity =
                          Vec3(numbers.velocity[0], numbers.velocity[1], numbers.velocity[2]),
                      .spin = Vec3(numbers.spin[0], numbers.spin[1], numbers.spin[2]),
                      .coast_seconds = numbers.coast_seconds};
    message.material = {.stiffness = numbers.stiffness,
                        .damping = numbers.damping,
                        .static_friction = numbers.static_friction,
                        .dynamic_friction = numbers.dynamic_friction};
    message.material_seconds = numbers.material_seconds;
    return message;
}

} // namespace proxima
