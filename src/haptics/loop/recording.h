// Sessions of touching, tick by tick: written to a file, read back, replayed bit for bit.
//
// Forces follow from the device's input, the models and the settings. The file has all of these but
// the models, which fingerprints stand for; and of a scene's objects the motions, be they scripts or
// what an engine sent.
#pragma once

#include "haptics/channel/scene_message.h"
#include "haptics/force/penalty_probe.h"
#include "haptics/scene/scripted_scene.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// One tick of a session. Lengths and forces in metres and newtons of the device.
struct RecordedTick {
    double seconds = 0; ///< since the first tick
    std::array<double, 3> position{};
    std::array<double, 3> velocity{};
    std::array<double, 3> force{};
    std::array<double, 3> proxy{}; ///< in the model's units
    std::uint32_t buttons = 0;
    std::uint32_t triangle = 0;  ///< of the first contact; 2^32 - 1 for none
    std::uint32_t hold = 0;      ///< Hold
    std::uint16_t fault = 0;     ///< InputFault
    std::uint16_t condition = 0; ///< InputCondition

    friend bool operator==(const RecordedTick&, const RecordedTick&) = default;
};

/// Settings of a session.
struct RecordingSettings {
    std::uint64_t mesh_fingerprint = 0;  ///< of one model at rest; 0 for a scene
    std::vector<ScriptedObject> objects; ///< of a scene; empty for one model at rest
    double room = 0;                     ///< of a scene, see ScriptedScene::make
    double tick_seconds = 1e-3;
    WorkspaceMap map;
    RenderOptions render;
    ForceLaw law = ForceLaw::proxy;
    double max_force = 3.3; ///< of the device
    double max_stiffness = 700;
    double max_damping = 5;
};

struct Recording {
    RecordingSettings settings;
    std::vector<RecordedTick> ticks;
    std::vector<SceneMessage> messages; ///< of an engine, by tick
};

/// The record of a tick.
[[nodiscard]] RecordedTick recorded(double seconds, const DeviceState& state,
                                    const RenderTick& tick) noexcept;

/// The device's state in a recorded tick.
[[nodiscard]] DeviceState device_state(const RecordedTick& tick) noexcept;

/// Whether two ticks have the same force and proxy, bit for bit.
[[nodiscard]] bool same_response(const RecordedTick& a, const RecordedTick& b) noexcept;

/// Writes a file (.pxt). Errors: those of write_binary_file.
[[nodiscard]] Status save_recording(const Recording& recording, const std::filesystem::path& path,
                                    Progress* progress = nullptr);

/// Reads a file. Errors: those of BinaryFile::open; malformed_file, naming a field that is out of
/// range (check_recording.h). Whatever the file holds, a recording that is returned can be replayed.
[[nodiscard]] Result<Recording> load_recording(const std::filesystem::path& path,
                                               Progress* progress = nullptr);

/// Like load_recording(), of a file in memory: see BinaryFile::read.
[[nodiscard]] Result<Recording> load_recording(std::span<const std::byte> bytes,
                                               std::shared_ptr<const void> storage,
                                               const std::string& name);

/// Replays a recording of one model with a new renderer. Returns the number of ticks in which force
/// or proxy have other bits than recorded.
[[nodiscard]] std::uint64_t count_differences(const Recording& recording,
                                              HapticRenderer& renderer) noexcept;

} // namespace proxima
