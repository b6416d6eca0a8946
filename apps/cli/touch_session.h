// A session of touching: a device, real or simulated, a model, and the loop between them.
#pragma once

#include "cli/index_file_model.h"
#include "cli/session.h"
#include "cli/touch_device.h"
#include "cli/touch_patches.h"
#include "cli/touch_plot.h"
#include "haptics/device/udp_device.h"
#include "haptics/force/passivity.h"
#include "haptics/force/surface_texture.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/surface/contact_surface.h"
#include "lab/hand_script.h"
#include "lab/quality_report.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace proxima {

/// What is touched: one model at rest, or a scene of objects.
struct TouchModel {
    ModelSurface surface; ///< of a scene, all its triangles where they stand at first
    MeshIndex index;
    std::optional<ThesisProximityOctree> thesis;        ///< where patches ask it
    std::unique_ptr<const IndexContactSurface> contact; ///< null of a scene
    std::unique_ptr<ScriptedScene> scene;               ///< null of one model at rest
    std::vector<std::string> object_names;              ///< of a scene
    std::vector<std::uint32_t> parts;                   ///< first triangles of its objects
    Box reach;       ///< what is touched never leaves it, but for an engine
    double room = 0; ///< of a scene, see ScriptedScene::make
    double build_seconds = 0;
};

/// Loads a mesh and builds its index, with closest-feature lists if `lists`; or loads a saved index as
/// it is.
[[nodiscard]] Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& model,
                                                                   bool lists, Session& session);

struct TouchSettings {
    TouchDeviceSettings device;
    std::string engine; ///< the channel to an engine, which needs a scene; "" for none
    InputOptions input;
    double seconds = 5;
    RenderOptions render;
    ForceLaw law = ForceLaw::proxy;
    Pace pace = Pace::real_time;
    bool record = false;
    bool trace = false;                   ///< keep the course of the session, for a plot
    std::optional<PatchSettings> patches; ///< none: the servo loop asks the octree itself
    double graphics_rate = 50;            ///< of what a terminal shows
};

/// Recording and course of a session hold no more, a recording of some nine hours: they are in
/// memory until the session ends.
inline constexpr double most_recorded_bytes = 4e9;

/// Refuses a session that would hold more than that, for the sake of the option. Error
/// budget_exceeded.
[[nodiscard]] Status check_recorded_bytes(double bytes, double seconds, const char* option);

/// What a check of a recording's settings said, as an error of --record before there is one. Error
/// invalid_argument.
[[nodiscard]] Status check_recordable(const Status& settings);

/// What recording and course of the session hold in memory.
[[nodiscard]] double recorded_bytes(const TouchSettings& settings);

/// Ticks after the session's end in which the force of a device fades that somebody holds.
[[nodiscard]] std::uint64_t ticks_to_release(const DeviceInfo& info, const TouchSettings& settings);

/// What became of a session's device.
struct DeviceAccount {
    DeviceInfo info;
    DeviceLimits limits; ///< as used
    InputReport input;
    std::optional<UdpReport> network; ///< of a device over UDP
    std::optional<HandModel> hand;    ///< of a simulated one
    std::uint64_t button_events = 0;
    bool interrupted = false; ///< by the user, before its time
    std::string trouble;      ///< "" for none
};

/// What became of a session's channel to an engine.
struct EngineAccount {
    std::string name;
    EngineReport report;
    std::string trouble;       ///< "" for none
    std::uint64_t dropped = 0; ///< messages that the recording lacks
};

struct TouchResult {
    QualityReport quality;
    ServoStatistics servo;
    LatencyHistogram render;   ///< of a tick's computing, ns, without the hand and the report
    std::uint64_t clamped = 0; ///< ticks in which a guard changed the force
    std::uint64_t slewed = 0;
    SwingReport swings; ///< what the passivity guard saw and did
    TextureReport texture;
    double session_seconds = 0; ///< of all ticks
    WorkspaceMap map;
    RenderOptions render_options; ///< as limited by the device
    ForceLaw law = ForceLaw::proxy;
    Recording recording;                 ///< empty unless asked for
    TouchTrace trace;                    ///< empty unless asked for
    std::optional<DeviceAccount> device; ///< none of a replay
    std::optional<PatchAccount> patches; ///< of patch mode
    std::optional<EngineAccount> engine;
};

/// A device touches the model in a thread of its own, while this one shows rate and force on a
/// terminal. Being cancelled ends it early, after the force has faded, with all results so far.
/// Errors: those of open_touch_device. \pre a scene is as it was made, and without patches
[[nodiscard]] Result<TouchResult> touch_by_device(const TouchModel& model,
                                                  const TouchSettings& settings, Session& session);

/// What replaying a recording showed.
struct ReplayResult {
    TouchResult touch;
    std::uint64_t differences = 0; ///< ticks with other bits than recorded
};

/// Feels a recording again, tick after tick, and keeps its course if `trace`. Errors: invalid_argument for another model; of a scene,
/// its loader has looked; cancelled. \pre a scene is as it was made
[[nodiscard]] Result<ReplayResult> replay_touch(const TouchModel& model, const Recording& recording,
                                                const std::string& path, bool trace,
                                                Session& session);

} // namespace proxima
