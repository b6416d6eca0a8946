// Which device touches a model in the viewer: the mouse, or one of those of `proxima touch`.
#pragma once

#include "cli/touch_device.h"
#include "viewer/controls.h"
#include "viewer/view_models.h"

#include <string>

namespace proxima {

/// Who moves the device.
enum class Hand : std::uint8_t {
    mouse,
    udp, ///< another program
    hd,  ///< OpenHaptics
    dhd  ///< Force Dimension
};

struct TouchDeviceChoice {
    Hand hand = Hand::mouse;
    std::string address = "4711"; ///< of udp: where packets come to
    std::string name;             ///< of hd: in the driver's setup; "" for the default device
    int number = 0;               ///< of dhd
    std::string library;          ///< of hd and dhd; "" to search
    std::string axes;             ///< what x, y and z are of the device's; "" for the usual ones

    /// The choice and what the device has to know. True where that was changed, or the device is to
    /// be opened once more.
    bool offer(Controls& controls);

    /// As `proxima touch --device` has it; "mouse".
    [[nodiscard]] std::string device() const;

    /// From the device's axes to those of a model that stands upright along `up`: without words of
    /// its own, what lies to the right of who holds the device lies to the right of who looks at
    /// the model's front, and above is above. Error invalid_argument where the words are no axes.
    [[nodiscard]] Result<Mat3> rotation(const Vec3& up) const;

    /// Opens the device for a model. Errors as open_touch_device. \pre hand is not the mouse
    [[nodiscard]] Result<TouchDevice> open(const ViewModel& model) const;
};

} // namespace proxima
