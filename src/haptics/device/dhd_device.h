// Devices of Force Dimension (omega, delta, sigma, lambda) and Novint's Falcon by the DHD API:
// libdhd.so, opened at run time. It is not needed to build, nor to run without such a device.
//
// Positions are metres already. Our servo loop polls: each tick reads and sets the force. Written
// after the public DHD API reference; tried with stub libraries, not yet on hardware.
#pragma once

#include "proxima/device.h"

#include <memory>
#include <string>

namespace proxima {

struct DhdOptions {
    int index = 0;            ///< of the devices that are plugged in
    std::string library = {}; ///< path of libdhd.so; "" to search for it
};

/// Opens the library and the device, and enables its forces. Limits are those of the model if it is
/// known, else an omega's. Errors: file_not_found (no library: what was tried, where, and what to
/// install), unsupported_format (functions that it lacks), invalid_argument (no device of that index,
/// or the driver's error).
[[nodiscard]] Result<std::unique_ptr<Device>> open_dhd_device(const DhdOptions& options);

} // namespace proxima
