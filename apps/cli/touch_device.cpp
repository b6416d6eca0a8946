#include "cli/touch_device.h"

#include "base/text.h"
#include "cli/touch_self_test.h"
#include "geometry/exact_predicates.h"
#include "lab/hand_device.h"
#include "lab/hand_script.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"

#include <string_view>

namespace proxima {

namespace {

/// "SCRIPT" of "hand:SCRIPT"; empty for other devices.
std::string_view script_of(std::string_view device)
{
    constexpr std::string_view prefix = "hand:";
    return device.starts_with(prefix) ? device.substr(prefix.size()) : std::string_view();
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

} // namespace

std::string touch_device_names()
{
    return concat("hand:SCRIPT, a script of ", hand_script_names(),
                  "; udp:PORT or udp:ADDRESS:PORT; hd or hd:NAME (OpenHaptics); dhd or dhd:INDEX "
                  "(Force Dimension); or replay:FILE");
}

std::string touch_device_problem(const std::string& device)
{
    constexpr std::string_view replay = "replay:";
    const bool replays = device.starts_with(replay) && device.size() > replay.size();
    const bool known = replays || device == self_test_hand || is_hand_script(script_of(device)) ||
                       is_device_name(device);
    return known ? std::string() : concat(device, " is not a device: use ", touch_device_names());
}

Result<TouchDevice> open_touch_device(const TouchDeviceSettings& settings, const Box& box,
                                      const TriangleMesh& mesh, const Topology& topology,
                                      std::span<const std::uint32_t> parts)
{
    const DeviceLimits limits = settings.limits.value_or(*find_device("omni"));
    if (is_device_name(settings.device)) {
        return ready(open_device(settings.device, {.library = settings.library, .limits = limits}),
                     settings, box);
    }
    auto script = HandScript::make(script_of(settings.device), mesh, topology,
                                   map_of(box, limits, settings.scale), settings.seed, parts);
    if (!script) return tl::unexpected(script.error());
    const Vec3 start = script->target(0);
    HandTarget target = [path = std::move(*script)](double seconds) {
        return path.target(seconds);
    };
    return ready(
        std::make_unique<HandDevice>("hand", settings.hand, std::move(target), start, limits),
        settings, box);
}

std::string_view word_of(Hold hold) noexcept
{
    if (hold == Hold::free) return "free";
    return hold == Hold::sticking ? "sticking" : "sliding";
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
    const OpenDeviceOptions options = {.library = library};
    add_found(found, "hd", open_device("hd", options));
    for (int index = 0; index < 64; ++index) {
        const std::string name = index == 0 ? "dhd" : concat("dhd:", index);
        const auto opened = open_device(name, options);
        if (!opened && index > 0) break; // they are numbered without gaps
        add_found(found, name, opened);
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
