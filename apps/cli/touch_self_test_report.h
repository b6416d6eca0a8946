// What a self-test found, as a page for people and as JSON.
#pragma once

#include "haptics/device/self_test_report.h"
#include "proxima/device.h"

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace proxima {

struct SelfTestPage {
    DeviceInfo info;
    DeviceLimits limits;
    SelfTestReport report;
    SelfTestOptions options;
    ServoStatistics servo;
    bool paced = true; ///< false: rates say nothing of the device
};

/// At most a screen of 30 lines.
[[nodiscard]] std::string self_test_text(const SelfTestPage& page);

[[nodiscard]] nlohmann::ordered_json self_test_json(const SelfTestPage& page);

} // namespace proxima
