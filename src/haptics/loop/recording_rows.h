// The rows of a recording's sections: settings, objects, messages and textures as numbers.
//
//     settings  one SettingNumbers
//     objects   an ObjectNumbers each       messages  a MessageNumbers each
//     textures  a TextureNumbers of the settings, then one of each object
#pragma once

#include "haptics/channel/scene_message.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace proxima {

/// The settings as numbers, in the order of the file.
struct SettingNumbers {
    double tick_seconds;
    double units_per_metre;
    double center[3];
    double stiffness;
    double damping;
    double max_slew;
    double start_seconds;
    double loss_seconds;
    double proxy_radius;
    double static_friction;
    double dynamic_friction;
    double guard; ///< 0 off, 1 on, 2 observe
    double max_jump;
    double max_force;
    double max_stiffness;
    double max_damping;
    double shading;
};
static_assert(sizeof(SettingNumbers) == 19 * sizeof(double));

/// An object of a scene, in the order of the file.
struct ObjectNumbers {
    double pose[12]; ///< (R | t) row by row
    double kind;     ///< ObjectMotionKind
    double along[3];
    double angle;
    double seconds;
    double has_material; ///< 0 or 1
    double stiffness;
    double damping;
    double static_friction;
    double dynamic_friction;
};
static_assert(sizeof(ObjectNumbers) == 23 * sizeof(double));

/// What an engine changed of an object, in the order of the file.
struct MessageNumbers {
    std::uint64_t tick;
    std::uint32_t object;
    std::uint32_t parts; ///< 1: a motion, 2: a material, 3: both
    double pose[12];     ///< (R | t) row by row
    double seconds;
    double velocity[3];
    double spin[3];
    double coast_seconds;
    double stiffness;
    double damping;
    double static_friction;
    double dynamic_friction;
    double material_seconds;
};
static_assert(sizeof(MessageNumbers) == 27 * sizeof(double));

/// A texture, in the order of the file.
struct TextureNumbers {
    double is_there; ///< 0 or 1; without one the others are those of no texture
    double shape;    ///< BumpShape
    double amplitude;
    double wavelength;
    double direction[3];
    double viscosity;
    double stick_stiffness;
    double stick_max_force;
    double tap_gain;
    double tap_frequency;
    double tap_decay;
};
static_assert(sizeof(TextureNumbers) == 13 * sizeof(double));

[[nodiscard]] SettingNumbers recording_row(const RecordingSettings& settings);
[[nodiscard]] ObjectNumbers recording_row(const ScriptedObject& object);
[[nodiscard]] MessageNumbers recording_row(const SceneMessage& message);
[[nodiscard]] TextureNumbers recording_row(const std::optional<SurfaceTexture>& given) noexcept;

/// The settings without objects and textures. \pre guard and shading were checked (check_choice)
[[nodiscard]] RecordingSettings settings_of(const SettingNumbers& numbers,
                                            std::uint64_t fingerprint);

/// Error malformed_file where the numbers make no object of a scene; `number` is for messages.
[[nodiscard]] Result<ScriptedObject> object_of(const ObjectNumbers& numbers,
                                               std::uint64_t fingerprint, std::size_t number);

/// Error malformed_file where the numbers make no message; its ranges are for check_recording.
[[nodiscard]] Result<SceneMessage> message_of(const MessageNumbers& numbers, std::size_t number);

/// \pre the shape was checked (check_choice)
[[nodiscard]] SurfaceTexture texture_of(const TextureNumbers& numbers) noexcept;

} // namespace proxima
