// What a session says of its device and of what came from it, for people and as JSON.
#pragma once

#include "cli/touch_session.h"

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace proxima {

/// Lines; the last ends with a line break. `damping` is the surface's, N s/m.
[[nodiscard]] std::string device_text(const DeviceAccount& account, double damping);

/// Adds "device_info", "hand", "input", "network", "button_events", "interrupted" and "trouble";
/// null and their likes for a replay, which has no device.
void add_device_json(nlohmann::ordered_json& json, const DeviceAccount* account, double damping);

/// What there is to know of devices, for --list-devices.
[[nodiscard]] std::string device_list_text(const std::vector<FoundDevice>& devices);
[[nodiscard]] nlohmann::ordered_json device_list_json(const std::vector<FoundDevice>& devices);

} // namespace proxima
