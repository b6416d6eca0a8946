// A session of touching: a device, real or simulated, a model, and the loop between them.
#pragma once

#include "cli/proximity_file_model.h"
#include "cli/session.h"
#include "proxima/base/result.h"
#include "proxima/haptics/contact_surface.h"
#include "proxima/haptics/hand_script.h"
#include "proxima/haptics/haptic_renderer.h"
#include "proxima/haptics/quality_report.h"
#include "proxima/haptics/recording.h"
#include "proxima/haptics/servo_loop.h"
#include "proxima/haptics/simulated_hand.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace proxima {

/// What is touched.
struct TouchModel {
    ModelSurface surface;
    ProximityOctree octree;
    std::unique_ptr<OctreeContactSurface> contact; ///< refers to the octree
    double build_seconds = 0;
};

/// A mesh or a saved proximity octree, ready to be touched.
[[nodiscard]] Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& model,
                                                                   Session& session);

struct TouchSettings {
    std::string script; ///< of the simulated hand
    std::uint64_t seed = 1;
    HandModel hand;
    double seconds = 5;
    DeviceLimits device;
    RenderOptions render;
    Pace pace = Pace::real_time;
    bool record = false;
};

struct TouchResult {
    QualityReport quality;
    ServoStatistics servo;
    LatencyHistogram render;   ///< of a tick's computing, ns, without the hand and the report
    std::uint64_t clamped = 0; ///< ticks in which a guard changed the force
    std::uint64_t slewed = 0;
    std::uint64_t damped = 0;
    double lowest_energy = 0; ///< J, of the passivity observer
    WorkspaceMap map;
    RenderOptions render_options; ///< as limited by the device
    Recording recording;          ///< empty unless asked for
};

/// A simulated hand touches the model in a thread of its own, while this one shows rate and force
/// on a terminal. Errors: those of HandScript::make, cancelled.
[[nodiscard]] Result<TouchResult> touch_by_hand(const TouchModel& model,
                                                const TouchSettings& settings, Session& session);

/// What replaying a recording showed.
struct ReplayResult {
    TouchResult touch;
    std::uint64_t differences = 0; ///< ticks with other bits than recorded
};

/// Feels a recording again, tick after tick. Error invalid_argument for another model.
[[nodiscard]] Result<ReplayResult> replay_touch(const TouchModel& model, const Recording& recording,
                                                const std::string& path);

} // namespace proxima
