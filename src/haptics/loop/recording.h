// Sessions of touching, tick by tick: written to a file, read back, replayed bit for bit.
//
// What was felt follows from what the device said, the models and the settings: the file has all of
// them but the models, of which it has the fingerprints. Of a scene it has how its objects moved.
#pragma once

#include "haptics/scene/scripted_scene.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace proxima {

/// What happened in one tick. Lengths and forces in metres and newtons, of the device.
struct RecordedTick {
    double seconds = 0; ///< since the first
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

/// Settings that a session was felt with.
struct RecordingSettings {
    std::uint64_t mesh_fingerprint = 0;  ///< of the one model; 0 of a scene
    std::vector<ScriptedObject> objects; ///< of a scene; empty for one model at rest
    double tick_seconds = 1e-3;
    WorkspaceMap map;
    RenderOptions render;
    double max_force = 3.3; ///< of the device
    double max_stiffness = 700;
    double max_damping = 5;
};

struct Recording {
    RecordingSettings settings;
    std::vector<RecordedTick> ticks;
};

/// A tick as it is recorded.
[[nodiscard]] RecordedTick recorded(double seconds, const DeviceState& state,
                                    const RenderTick& tick) noexcept;

/// What the device said in a recorded tick.
[[nodiscard]] DeviceState device_state(const RecordedTick& tick) noexcept;

/// Whether two ticks have the same force and proxy, bit for bit.
[[nodiscard]] bool same_feeling(const RecordedTick& a, const RecordedTick& b) noexcept;

/// Writes a file (.pxt). Errors: those of write_binary_file.
[[nodiscard]] Status save_recording(const Recording& recording, const std::filesystem::path& path,
                                    Progress* progress = nullptr);

/// Reads it. Errors: those of BinaryFile::open; malformed_file where settings are out of range.
[[nodiscard]] Result<Recording> load_recording(const std::filesystem::path& path,
                                               Progress* progress = nullptr);

/// Feels a recording of one model again with a renderer as new. Returns in how many ticks force or
/// proxy had other bits than recorded.
[[nodiscard]] std::uint64_t count_differences(const Recording& recording,
                                              HapticRenderer& renderer) noexcept;

} // namespace proxima
