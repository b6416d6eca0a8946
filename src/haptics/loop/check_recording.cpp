#include "haptics/loop/check_recording.h"

#include "base/text.h"
#include "haptics/scene/object_script.h"
#include "haptics/scene/scene_input.h"
#include "haptics/surface/height_field.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

namespace proxima {

namespace {

/// The numbers that a field may have.
struct Range {
    double least;
    double most;
};

/// Servo loops run at 1 Hz to 1 MHz. So the time of any tick that a file can hold is finite, and an
/// update of a scene (seconds_per_update) comes every 1 to 20,000 ticks.
constexpr Range tick_range = {1e-6, 1};

/// Coordinates are at most 1e100, as those of a scripted scene, so that squares of distances and
/// their products with a stiffness are finite, and a model is at least as many times smaller than the
/// largest one as squares of distances in it are normal numbers.
constexpr Range scale_range = {1e-100, 1e100};
constexpr Range coordinate_range = {-1e100, 1e100};

/// Stiffness, damping, friction, forces and their slew: at least 10^4 times what any device of
/// known_devices() takes and what the options of `proxima touch` allow.
constexpr Range strength_range = {0, 1e9};

/// A device with no force has nothing to replay. Forces are divided by lengths of forces only.
constexpr Range force_range = {1e-9, strength_range.most};

/// A day, the longest session.
constexpr Range ramp_range = {0, 86400};

/// Metres. An input is at most 10 m from the device's origin along each axis
/// (InputOptions::max_distance). Each press of a clutch may add as much: this allows for 10^5.
constexpr Range position_range = {-1e6, 1e6};

/// Metres: the largest distance of two positions.
constexpr Range length_range = {0, 4e6};

tl::unexpected<Error> out_of_range(const std::string& field, double value, const Range& range)
{
    return fail(ErrorCode::malformed_file,
                concat(field, " is ", value, " and must be ", range.least, " to ", range.most));
}

bool contains(const Range& range, double value) noexcept
{
    return value >= range.least && value <= range.most;
}

struct Field {
    std::string_view name;
    double value;
    Range range;
};

template <std::size_t Count>
Status check_fields(const std::array<Field, Count>& fields, const std::string& of = {})
{
    for (const Field& field : fields) {
        if (!contains(field.range, field.value))
            return out_of_range(concat(of, field.name), field.value, field.range);
    }
    return {};
}

Status check_frictions(double dynamic, double fixed, const std::string& of = {})
{
    if (dynamic <= fixed) return {};
    return out_of_range(concat(of, "dynamic_friction"), dynamic, {0, fixed});
}

Status check_recorded_texture(const SurfaceTexture& texture, const std::string& of = {})
{
    const Status status = check_texture(texture);
    if (status) return {};
    return fail(ErrorCode::malformed_file, concat(of, status.error().message));
}

Status check_settings(const RecordingSettings& settings)
{
    const RenderOptions& render = settings.render;
    const ForceOptions& force = render.force;
    const Vec3& center = settings.map.center;
    Status status = check_fields(
        std::array<Field, 17>{{{"tick_seconds", settings.tick_seconds, tick_range},
                               {"units_per_metre", settings.map.units_per_metre, scale_range},
                               {"center x", center.x(), coordinate_range},
                               {"center y", center.y(), coordinate_range},
                               {"center z", center.z(), coordinate_range},
                               {"stiffness", force.stiffness, strength_range},
                               {"damping", force.damping, strength_range},
                               {"max_slew", force.max_slew, strength_range},
                               {"start_seconds", force.start_seconds, ramp_range},
                               {"loss_seconds", force.loss_seconds, ramp_range},
                               {"proxy_radius", render.proxy_radius, length_range},
                               {"static_friction", render.static_friction, strength_range},
                               {"dynamic_friction", render.dynamic_friction, strength_range},
                               {"max_jump", render.max_jump, length_range},
                               {"max_force", settings.max_force, force_range},
                               {"max_stiffness", settings.max_stiffness, strength_range},
                               {"max_damping", settings.max_damping, strength_range}}});
    if (status) status = check_frictions(render.dynamic_friction, render.static_friction);
    return status ? check_recorded_texture(render.texture) : status;
}

Status check_object(const ScriptedObject& object, std::size_t number)
{
    const std::string of = concat("object ", number, ": ");
    const Vec3& at = object.pose.translation;
    Status status = check_fields(std::array<Field, 3>{{{"pose x", at.x(), coordinate_range},
                                                       {"pose y", at.y(), coordinate_range},
                                                       {"pose z", at.z(), coordinate_range}}},
                                 of);
    if (!status) return status;
    if (status = check_script(object.script); !status) {
        return fail(ErrorCode::malformed_file, concat(of, status.error().message));
    }
    if (object.texture) {
        if (status = check_recorded_texture(*object.texture, of); !status) return status;
    }
    if (!object.material) return {};
    const SurfaceMaterial& material = *object.material;
    status = check_fields(
        std::array<Field, 4>{{{"stiffness", material.stiffness, strength_range},
                              {"damping", material.damping, strength_range},
                              {"static_friction", material.static_friction, strength_range},
                              {"dynamic_friction", material.dynamic_friction, strength_range}}},
        of);
    return status ? check_frictions(material.dynamic_friction, material.static_friction, of)
                  : status;
}

/// Diagonals of the objects' box: the coordinates of a scene stay finite.
constexpr Range room_range = {0, 1e6};

/// Radians per second, along each axis.
constexpr Range spin_range = {-most_spin, most_spin};

/// What TouchScene refuses beyond this, such as a pose out of its bounds, ends a replay with an error.
Status check_message(const Recording& recording, std::size_t number)
{
    const SceneMessage& message = recording.messages[number];
    const std::string of = concat("message ", number, ": ");
    const std::size_t objects = recording.settings.objects.size();
    if (to_index(message.object) >= objects) {
        return fail(ErrorCode::malformed_file, concat(of, "object is ", to_index(message.object),
                                                      ", and there are ", objects));
    }
    if (number > 0 && message.tick < recording.messages[number - 1].tick) {
        return fail(ErrorCode::malformed_file, concat(of, "its tick is before that of the last"));
    }
    const ObjectMotion& motion = message.motion;
    const Vec3& at = motion.pose.translation;
    const Vec3& v = motion.velocity;
    const SurfaceMaterial& material = message.material;
    Status status = check_fields(
        std::array<Field, 16>{{{"pose x", at.x(), coordinate_range},
                               {"pose y", at.y(), coordinate_range},
                               {"pose z", at.z(), coordinate_range},
                               {"seconds", motion.seconds, ramp_range},
                               {"velocity x", v.x(), coordinate_range},
                               {"velocity y", v.y(), coordinate_range},
                               {"velocity z", v.z(), coordinate_range},
                               {"spin x", motion.spin.x(), spin_range},
                               {"spin y", motion.spin.y(), spin_range},
                               {"spin z", motion.spin.z(), spin_range},
                               {"coast_seconds", motion.coast_seconds, ramp_range},
                               {"stiffness", material.stiffness, strength_range},
                               {"damping", material.damping, strength_range},
                               {"static_friction", material.static_friction, strength_range},
                               {"dynamic_friction", material.dynamic_friction, strength_range},
                               {"material_seconds", message.material_seconds, ramp_range}}},
        of);
    return status ? check_frictions(material.dynamic_friction, material.static_friction, of)
                  : status;
}

} // namespace

Status check_recording(const Recording& recording)
{
    const RecordingSettings& settings = recording.settings;
    if (Status status = check_settings(settings); !status) return status;
    for (std::size_t i = 0; i < settings.objects.size(); ++i) {
        if (Status status = check_object(settings.objects[i], i); !status) return status;
    }
    if (Status status = check_fields(std::array<Field, 1>{{{"room", settings.room, room_range}}});
        !status)
        return status;
    for (std::size_t i = 0; i < recording.messages.size(); ++i) {
        if (Status status = check_message(recording, i); !status) return status;
    }
    return {};
}

Status check_tick(const RecordedTick& tick, std::size_t number)
{
    // NaN stands for no position: before a device's first good sample there is none.
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at = tick.position[axis];
        if (std::isnan(at) || contains(position_range, at)) continue;
        constexpr std::array names = {"x", "y", "z"};
        return out_of_range(concat("tick ", number, ": position ", names[axis]), at,
                            position_range);
    }
    if (tick.condition < input_conditions) return {};
    return out_of_range(concat("tick ", number, ": condition"), tick.condition,
                        {0, input_conditions - 1});
}

} // namespace proxima
