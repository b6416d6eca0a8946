// The devices that a model can be touched with, by the names of the command line.
#pragma once

#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// "hand:SCRIPT, ..." as help and errors say it.
[[nodiscard]] std::string touch_device_names();

/// What is wrong with a device's name; "" where it is one that can be tried.
[[nodiscard]] std::string touch_device_problem(const std::string& device);

/// Which device, and what it needs to know.
struct TouchDeviceSettings {
    std::string device;  ///< hand:SCRIPT, udp:[ADDRESS:]PORT, hd[:NAME], dhd[:INDEX]
    std::string library; ///< of hd and dhd; "" to search
    std::optional<DeviceLimits>
        limits;             ///< none beyond them; a hand's and UDP's own, else an omni's
    double scale = 1;       ///< motions in the model, over those that fit it in
    std::uint64_t seed = 1; ///< of a hand's script
    HandModel hand;
};

/// A device, ready, and how its workspace lies about the model.
struct TouchDevice {
    std::unique_ptr<Device> device;
    DeviceLimits limits;
    WorkspaceMap map;
};

/// The workspace is laid about the box; the mesh, of objects that begin at the triangles of
/// `parts`, is what a hand's script goes by. Errors: those of HandScript::make and open_device.
[[nodiscard]] Result<TouchDevice> open_touch_device(const TouchDeviceSettings& settings,
                                                    const Box& box, const TriangleMesh& mesh,
                                                    const Topology& topology,
                                                    std::span<const std::uint32_t> parts);

/// "well", "silent", ...: how a device's input is.
[[nodiscard]] std::string_view word_of(InputCondition condition) noexcept;
[[nodiscard]] std::string_view word_of(Hold hold) noexcept;

/// A device that was looked for.
struct FoundDevice {
    std::string name;
    std::optional<DeviceInfo> info; ///< none: see the problem
    std::string problem;
};

/// Looks for every kind: opens and closes what is there. Their forces stay zero.
[[nodiscard]] std::vector<FoundDevice> look_for_devices(const std::string& library);

/// "x,-z,y": what our x, y and z are of the device's axes. Error invalid_argument where that is no
/// rotation.
[[nodiscard]] Result<Mat3> parse_axes(const std::string& text);

} // namespace proxima
