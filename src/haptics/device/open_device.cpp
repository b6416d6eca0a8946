#include "base/text.h"
#include "base/udp_socket.h"
#include "haptics/device/dhd_device.h"
#include "haptics/device/hd_device.h"
#include "haptics/device/udp_device.h"
#include "proxima/device.h"

#include <charconv>
#include <string>

namespace proxima {

namespace {

/// "kind:rest", as is_device_name() accepts it.
struct DeviceName {
    explicit DeviceName(std::string_view name)
        : kind(name.substr(0, name.find(':'))), has_rest(kind.size() < name.size()),
          rest(has_rest ? name.substr(kind.size() + 1) : "")
    {}

    std::string_view kind;
    bool has_rest;
    std::string rest;
};

std::optional<int> device_index(std::string_view text)
{
    int index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole && index >= 0 && index < 64 ? std::optional(index) : std::nullopt;
}

Result<std::unique_ptr<Device>> open_udp(const std::string& address, const DeviceLimits& limits)
{
    const auto parsed = parse_udp_address(address);
    if (!parsed) return tl::unexpected(parsed.error());
    auto device = UdpDevice::open({.address = *parsed, .limits = limits});
    if (!device) return tl::unexpected(device.error());
    return std::move(*device);
}

} // namespace

bool is_device_name(std::string_view name)
{
    const DeviceName parts(name);
    if (parts.kind == "udp") return parse_udp_address(parts.rest).has_value();
    if (parts.kind == "dhd") return !parts.has_rest || device_index(parts.rest);
    return parts.kind == "hd" && parts.has_rest != parts.rest.empty();
}

Result<std::unique_ptr<Device>> open_device(std::string_view name, const OpenDeviceOptions& options)
{
    const DeviceName parts(name);
    if (!is_device_name(name)) {
        return fail(ErrorCode::invalid_argument,
                    concat(name,
                           " is not a device: use udp:PORT, udp:ADDRESS:PORT, hd, hd:NAME, dhd "
                           "or dhd:INDEX"));
    }
    if (parts.kind == "udp") return open_udp(parts.rest, options.limits);
    if (parts.kind == "hd")
        return open_hd_device({.device = parts.rest, .library = options.library});
    return open_dhd_device(
        {.index = device_index(parts.rest).value_or(0), .library = options.library});
}

} // namespace proxima
