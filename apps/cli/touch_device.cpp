#include "cli/touch_device.h"

#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "haptics/device/dhd_device.h"
#include "haptics/device/hd_device.h"
#include "haptics/device/udp_device.h"
#include "lab/hand_device.h"
#include "lab/hand_script.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace proxima {

namespace {

/// "kind:rest"
struct DeviceName {
    std::string_view kind;
    std::string_view rest;
    bool has_rest = false;
};

DeviceName split(std::string_view name)
{
    const std::size_t colon = name.find(':');
    if (colon == std::string_view::npos) return {name, {}, false};
    return {name.substr(0, colon), name.substr(colon + 1), true};
}

std::optional<int> index_of(std::string_view text)
{
    int index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole && index >= 0 && index < 64 ? std::optional(index) : std::nullopt;
}

WorkspaceMap map_of(const Box& box, const DeviceLimits& limits, double scale)
{
    WorkspaceMap map = fit_workspace(box, limits.workspace_radius);
    map.units_per_metre *= scale;
    return map;
}

template <class Opened>
void add_found(std::vector<FoundDevice>& found, const std::string& name, const Opened& opened)
{
    if (opened) {
        found.push_back({name, (*opened)->info(), {}});
    } else {
        found.push_back({name, std::nullopt, describe(opened.error())});
    }
}

Result<TouchDevice> ready(Result<std::unique_ptr<Device>> device,
                          const TouchDeviceSettings& settings, const Box& box)
{
    if (!device) return tl::unexpected(device.error());
    TouchDevice result;
    result.device = std::move(*device);
    result.limits = result.device->info().limits;
    if (settings.limits) result.limits = within(result.limits, *settings.limits);
    result.map = map_of(box, result.limits, settings.scale);
    return result;
}

Result<std::unique_ptr<Device>> open_udp(std::string_view address, const DeviceLimits& limits)
{
    const auto parsed = parse_udp_address(address);
    if (!parsed) return tl::unexpected(parsed.error());
    auto device = UdpDevice::open({.address = *parsed, .limits = limits});
    if (!device) return tl::unexpected(device.error());
    return std::move(*device);
}

} // namespace

std::string touch_device_names()
{
    return concat("hand:SCRIPT, a script of ", hand_script_names(),
                  "; udp:PORT or udp:ADDRESS:PORT; hd or hd:NAME (OpenHaptics); dhd or dhd:INDEX "
                  "(Force Dimension); or replay:FILE");
}

std::string touch_device_problem(const std::string& device)
{
    const DeviceName name = split(device);
    const std::string rest(name.rest);
    const bool known = (name.kind == "replay" && !rest.empty()) ||
                       (name.kind == "hand" && is_hand_script(rest)) ||
                       (name.kind == "udp" && parse_udp_address(rest)) ||
                       (name.kind == "hd" && name.has_rest != rest.empty()) ||
                       (name.kind == "dhd" && (name.has_rest ? index_of(rest).has_value() : true));
    return known ? std::string() : concat(device, " is no device: give ", touch_device_names());
}

Result<TouchDevice> open_touch_device(const TouchDeviceSettings& settings, const Box& box,
                                      const TriangleMesh& mesh, const Topology& topology,
                                      std::span<const std::uint32_t> parts)
{
    const DeviceName name = split(settings.device);
    const std::string rest(name.rest);
    const DeviceLimits limits = settings.limits.value_or(*find_device("omni"));
    if (name.kind == "hd") {
        return ready(open_hd_device({.device = rest, .library = settings.library}), settings, box);
    }
    if (name.kind == "dhd") {
        const int index = name.has_rest ? index_of(rest).value_or(0) : 0;
        return ready(open_dhd_device({.index = index, .library = settings.library}), settings, box);
    }
    if (name.kind == "udp") return ready(open_udp(rest, limits), settings, box);
    auto script = HandScript::make(rest, mesh, topology, map_of(box, limits, settings.scale),
                                   settings.seed, parts);
    if (!script) return tl::unexpected(script.error());
    const Vec3 start = script->target(0);
    HandTarget target = [path = std::move(*script)](double seconds) {
        return path.target(seconds);
    };
    return ready(
        std::make_unique<HandDevice>("hand", settings.hand, std::move(target), start, limits),
        settings, box);
}

std::string_view word_of(InputCondition condition) noexcept
{
    switch (condition) {
    case InputCondition::well:
        break;
    case InputCondition::clutched:
        return "clutched";
    case InputCondition::unsure:
        return "unsure";
    case InputCondition::frozen:
        return "frozen";
    case InputCondition::silent:
        return "silent";
    case InputCondition::gone:
        return "gone";
    case InputCondition::released:
        return "released";
    }
    return "well";
}

std::vector<FoundDevice> look_for_devices(const std::string& library)
{
    std::vector<FoundDevice> found;
    add_found(found, "hd", open_hd_device({.library = library}));
    for (int index = 0; index < 64; ++index) {
        const auto opened = open_dhd_device({.index = index, .library = library});
        if (!opened && index > 0) break; // they are numbered without gaps
        add_found(found, index == 0 ? "dhd" : concat("dhd:", index), opened);
        if (!opened) break;
    }
    return found;
}

Result<Mat3> parse_axes(const std::string& text)
{
    Mat3 axes = Mat3::Zero();
    std::string_view left = text;
    int row = 0;
    for (; row < 3 && !left.empty(); ++row) {
        const double sign = left.front() == '-' ? -1 : 1;
        if (left.front() == '-' || left.front() == '+') left.remove_prefix(1);
        const std::size_t axis = left.empty() ? 3 : std::string_view("xyz").find(left.front());
        if (axis > 2) break;
        axes(row, static_cast<int>(axis)) = sign;
        left.remove_prefix(1);
        if (row < 2 && !left.empty() && left.front() == ',') left.remove_prefix(1);
    }
    if (row == 3 && left.empty() && axes.determinant() == 1) return axes;
    return fail(ErrorCode::invalid_argument,
                concat(text, " is no rotation of axes: give what x, y and z are of the device's, "
                             "such as y,z,x or x,-z,y"));
}

} // namespace proxima
