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
    std::string library; ///< of hd and dhd: path of the driver's library; "" to search for it
    std::string axes;    ///< how the model's axes follow from the device's; "" for the default

    /// Offers the choice and the settings of the chosen device. True if one was changed, or if the
    /// device is to be opened again.
    bool offer(Controls& controls);

    /// As `proxima touch --device` has it; "mouse".
    [[nodiscard]] std::string device() const;

    /// The rotation from the device's axes to those of a model that stands upright along `up`. If
    /// `axes` is empty, right and up of the person who holds the device are right and up of a
    /// person who looks at the front of the model. Error invalid_argument if `axes` is invalid.
    [[nodiscard]] Result<Mat3> rotation(const Vec3& up) const;

    /// Opens the device for a model. Errors as open_touch_device. \pre hand is not the mouse
    [[nodiscard]] Result<TouchDevice> open(const ViewModel& model) const;
};

} // namespace proxima
