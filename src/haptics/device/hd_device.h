// Devices of 3D Systems (Touch, Touch X, Phantom Omni, Desktop, Premium) by OpenHaptics' HD API:
// libHD.so, opened at run time. It is not needed to build, nor to run without such a device.
//
//     scheduler of libHD, 1,000 Hz ──▶ callback ──▶ tick ──▶ read(): frame begins, pose, buttons
//                                                        └─▶ write(): force, frame ends
//
// The tick runs in the driver's own callback, without the delay of a hand-over. Written after the
// public OpenHaptics API reference; tried with stub libraries, not yet on hardware.
#pragma once

#include "proxima/device.h"

#include <memory>
#include <string>

namespace proxima {

struct HdOptions {
    std::string device = {};  ///< its name in the driver's setup; "" for the default one
    std::string library = {}; ///< path of libHD.so; "" to search for it
};

/// Opens the library and the device, and enables its forces. Millimetres become metres; limits are
/// those that the driver reports. Errors: file_not_found (no library: what was tried, where, and what
/// to install), unsupported_format (functions that it lacks), invalid_argument (the driver's error),
/// limit_exceeded (the device has to be calibrated first).
[[nodiscard]] Result<std::unique_ptr<Device>> open_hd_device(const HdOptions& options);

} // namespace proxima
