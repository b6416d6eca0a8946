// Sessions of a tool, tick by tick: written to a file, read back, replayed bit for bit.
//
// Forces and torques follow from the device's poses, the meshes and the settings. The file has all of
// these but the meshes, which fingerprints stand for. It is a file of its own kind beside that of points
// (recording.h), whose ticks have no rotations.
#pragma once

#include "proxima/device.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/tool_renderer.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// One tick of a session. Of the device in metres and newtons; poses are (R | t) row by row.
struct RecordedToolTick {
    std::array<double, 12> device{};
    std::array<double, 12> proxy{}; ///< in the model's units
    std::array<double, 3> force{};
    std::array<double, 3> torque{};
    std::uint32_t condition = 0; ///< InputCondition
    std::uint32_t buttons = 0;

    friend bool operator==(const RecordedToolTick&, const RecordedToolTick&) = default;
};

struct ToolRecordingSettings {
    std::uint64_t model_fingerprint = 0;
    std::uint64_t tool_fingerprint = 0; ///< of the mesh that the renderer was given
    double tick_seconds = 1e-3;
    WorkspaceMap map;
    ToolRenderOptions render; ///< as make_tool_renderer was given them
    double max_force = 3.3;   ///< of the device
    double max_stiffness = 700;
    double max_damping = 5;
    double max_torque = 0;

    /// What the renderer needs to know of the device.
    [[nodiscard]] DeviceLimits device() const;
};

struct ToolRecording {
    ToolRecordingSettings settings;
    std::vector<RecordedToolTick> ticks;
};

/// Error malformed_file, without a place or advice, naming the first number that is out of range:
/// load_tool_recording refuses it.
[[nodiscard]] Status check_settings(const ToolRecordingSettings& settings);

[[nodiscard]] RecordedToolTick recorded(const DeviceState& state, const ToolTick& tick) noexcept;

/// The device's state in a recorded tick.
[[nodiscard]] DeviceState device_state(const RecordedToolTick& tick) noexcept;

/// Whether two ticks have the same force, torque and proxy, bit for bit.
[[nodiscard]] bool same_response(const RecordedToolTick& a, const RecordedToolTick& b) noexcept;

/// Writes a file (.pxt). Errors: those of write_binary_file.
[[nodiscard]] Status save_tool_recording(const ToolRecording& recording,
                                         const std::filesystem::path& path,
                                         Progress* progress = nullptr);

/// Reads a file. Errors: those of BinaryFile::open; malformed_file, naming a number that is out of
/// range. Poses may be anything, as those of a device.
[[nodiscard]] Result<ToolRecording> load_tool_recording(const std::filesystem::path& path,
                                                        Progress* progress = nullptr);

/// Like load_tool_recording(), of a file in memory: see BinaryFile::read.
[[nodiscard]] Result<ToolRecording> load_tool_recording(std::span<const std::byte> bytes,
                                                        std::shared_ptr<const void> storage,
                                                        const std::string& name);

} // namespace proxima
