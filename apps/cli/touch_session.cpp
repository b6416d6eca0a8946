#include "cli/touch_session.h"

#include "base/progress.h"
#include "base/text.h"
#include "cli/model_options.h"
#include "cli/stderr_text.h"
#include "cli/stopwatch.h"
#include "haptics/channel/engine_link.h"
#include "haptics/device/button_queue.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/check_recording.h"
#include "haptics/loop/snapshot.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/exits.h"
#include "haptics/surface/shading_normals.h"
#include "lab/hand_device.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fmt/core.h>
#include <thread>
#include <unistd.h>

namespace proxima {

namespace {

std::int64_t nanoseconds_now() noexcept
{
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

Status build_index_of(TouchModel& model, const std::string& name, bool lists, Session& session)
{
    auto mesh = session.load_model(name);
    if (!mesh) return tl::unexpected(mesh.error());
    auto surface = surface_of(std::move(*mesh), name, session);
    if (!surface) return tl::unexpected(surface.error());
    model.surface = std::move(*surface);
    const ProgressBar shown(session.progress(), session.bar());
    auto index = build_mesh_index(model.surface.mesh, {.execution = session.execution()});
    if (index && lists) index = with_lists(*index, {.execution = session.execution()});
    if (!index) return at_model(index.error(), name);
    model.index = *index;
    return {};
}

Status open_index(TouchModel& model, const std::string& name, Session& session)
{
    auto index = load_index_file(name, session);
    if (!index) return tl::unexpected(index.error());
    model.index = *index;
    auto surface = surface_of(model.index, name, session);
    if (!surface) return tl::unexpected(surface.error());
    model.surface = std::move(*surface);
    return {};
}

/// What the terminal shows while the hand is at it.
struct LiveTouch {
    double seconds = 0;
    std::uint64_t ticks = 0;
    double force = 0;
    Hold hold = Hold::free;
    InputCondition condition = InputCondition::well;
};

std::string_view word_of(const LiveTouch& now)
{
    if (now.condition != InputCondition::well) return word_of(now.condition);
    return word_of(now.hold);
}

/// What a renderer of one model at rest refers to beside its surface; a scene's objects have their
/// own.
struct RenderParts {
    std::unique_ptr<ShadingNormals> normals; ///< of shaded forces
    std::optional<MeshIndex> signed_index;   ///< of penalty forces
};

Result<RenderParts> parts_for(const TouchModel& model, const RenderOptions& options, ForceLaw law,
                              Session& session)
{
    RenderParts parts;
    if (model.scene != nullptr) return parts;
    const auto& [mesh, topology] = model.surface;
    if (options.shading == ForceShading::on)
        parts.normals = std::make_unique<ShadingNormals>(mesh, topology);
    if (law == ForceLaw::penalty) {
        const ProgressBar shown(session.progress(), session.bar());
        const auto index = model.index.has_signs()
                               ? model.index
                               : with_signs(model.index, {.execution = session.execution()});
        if (!index) return tl::unexpected(index.error());
        parts.signed_index = *index;
    }
    return parts;
}

/// What an engine changed, on its way from the servo thread to the recording. As much as engines send
/// in a second that move all objects 250 times.
using SceneMessageQueue = EventQueue<SceneMessage, 16384>;

/// What moves the objects of a scene beside their scripts.
struct SceneMover {
    EngineLink* engine = nullptr;                ///< null of a replay
    SceneMessageQueue* recorded = nullptr;       ///< gets what the engine sent; may be null
    std::span<const SceneMessage> replayed = {}; ///< by tick
};

/// Renders and keeps account; all that the loop calls is without allocation.
class TouchRun {
public:
    /// With what parts_for() gave and, in patch mode, patches: both must outlive it, and so must what
    /// `mover` refers to.
    /// \pre check_render_settings() holds
    TouchRun(const TouchModel& model, const RenderParts& parts, const WorkspaceMap& map,
             const DeviceLimits& device, const RenderOptions& options, const SceneMover& mover,
             PatchTouch* patches = nullptr)
        : patches_(patches), mover_(mover), scene_(model.scene.get()),
          renderer_(renderer_of(model, patches, parts, map, device, options)),
          meter_(scene_ != nullptr ? QualityMeter(scene_->scene(), map)
                                   : QualityMeter(*model.contact, map))
    {}

    const RenderTick& tick(const DeviceState& state, double seconds) noexcept
    {
        if (scene_ != nullptr) move_objects(seconds);
        result_.session_seconds += seconds;
        const std::int64_t begin = nanoseconds_now();
        const Patch patch = patches_ == nullptr ? Patch::available : patches_->begin_tick();
        const RenderTick& rendered = renderer_.tick(state, seconds, patch);
        result_.render.add(nanoseconds_now() - begin);
        if (patches_ != nullptr) patches_->end_tick(rendered);
        meter_.add(rendered, state.velocity, renderer_.path());
        if (parts_of(renderer_).popped()) meter_.add_pass();
        return rendered;
    }

    [[nodiscard]] const HapticRenderer& renderer() const noexcept { return renderer_; }

    /// What was wrong with a message of a replay.
    [[nodiscard]] const Status& replayed() const noexcept { return replayed_; }

    [[nodiscard]] TouchResult finish() &&
    {
        result_.quality = meter_.report();
        result_.clamped = parts_of(renderer_).guard().clamped();
        result_.slewed = parts_of(renderer_).guard().slewed();
        result_.swings = parts_of(renderer_).passivity().report();
        result_.texture = parts_of(renderer_).texture().report();
        result_.map = renderer_.map();
        result_.render_options = renderer_.options();
        return std::move(result_);
    }

private:
    static HapticRenderer renderer_of(const TouchModel& model, PatchTouch* patches,
                                      const RenderParts& parts, const WorkspaceMap& map,
                                      const DeviceLimits& device, const RenderOptions& options)
    {
        if (model.scene != nullptr)
            return make_haptic_renderer(model.scene->scene(), map, device, options).value();
        const ContactSurface& surface = patches == nullptr ? *model.contact : patches->surface();
        if (parts.signed_index)
            return make_penalty_renderer(surface, *parts.signed_index, map, device, options);
        return make_surface_renderer(surface, map, device, options, parts.normals.get());
    }

    void move_objects(double seconds) noexcept
    {
        TouchScene& scene = scene_->scene();
        if (mover_.engine != nullptr) {
            const auto messages = mover_.engine->receive(scene, ticks_, seconds, nanoseconds_now());
            for (const SceneMessage& message : messages)
                if (mover_.recorded != nullptr) mover_.recorded->push(message);
        }
        auto& left = mover_.replayed;
        for (; !left.empty() && left.front().tick <= ticks_; left = left.subspan(1))
            if (replayed_) replayed_ = apply(left.front(), scene);
        scene_->send_motions(ticks_++, seconds);
    }

    PatchTouch* patches_;
    SceneMover mover_;
    Status replayed_;
    ScriptedScene* scene_;
    std::uint64_t ticks_ = 0;
    HapticRenderer renderer_;
    QualityMeter meter_;
    TouchResult result_;
};

/// The graphics loop: rate and force on a terminal, until `ended`, and the engine's messages for the
/// recording. Returns how many button events there were.
std::uint64_t show_live(Snapshot<LiveTouch>& live, DeviceInput& input,
                        const std::atomic<bool>& ended, bool shown, double graphics_rate,
                        SceneMessageQueue* queue, std::vector<SceneMessage>& messages)
{
    // Beyond this they fill the queue, which counts what it drops.
    constexpr auto most_messages =
        static_cast<std::size_t>(most_recorded_bytes / sizeof(SceneMessage));
    const auto take_messages = [&] {
        while (queue != nullptr && messages.size() < most_messages) {
            const auto message = queue->pop();
            if (!message) break;
            messages.push_back(*message);
        }
    };
    std::uint64_t events = 0;
    const auto pause = std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(1 / graphics_rate));
    // Ten lines a second are as many as can be read.
    const int pauses_per_line = std::max(1, static_cast<int>(graphics_rate / 10));
    LiveTouch last;
    for (int pauses = 1; !ended.load(); ++pauses) {
        std::this_thread::sleep_for(pause);
        while (input.next_button_event()) ++events;
        take_messages();
        if (!shown || pauses % pauses_per_line != 0 || !live.update()) continue;
        const LiveTouch& now = live.reading();
        const double span = now.seconds - last.seconds;
        const double rate = span > 0 ? static_cast<double>(now.ticks - last.ticks) / span : 0;
        const auto bar = static_cast<std::size_t>(std::min(now.force, 10.0) * 4);
        print_stderr("\r\x1b[K{:5.1f} s {:6.0f} Hz {:6.3f} N {:8} {:#<{}}", now.seconds, rate,
                     now.force, word_of(now), "", bar);
        last = now;
    }
    if (shown) write_stderr("\r\x1b[K");
    while (input.next_button_event()) ++events;
    take_messages();
    return events;
}

/// Of one model at rest; a scene's objects have their own.
std::uint64_t fingerprint_of(const TouchModel& model)
{
    return model.scene != nullptr ? 0 : model.index.mesh_fingerprint();
}

std::vector<ScriptedObject> objects_of(const TouchModel& model)
{
    if (model.scene == nullptr) return {};
    const std::span<const ScriptedObject> objects = model.scene->objects();
    return {objects.begin(), objects.end()};
}

} // namespace

std::uint64_t ticks_to_release(const DeviceInfo& info, const TouchSettings& settings)
{
    if (!info.pushes) return 0;
    const double fading = settings.render.force.loss_seconds / settings.input.tick_seconds;
    return static_cast<std::uint64_t>(std::ceil(fading)) + 5;
}

Status check_recorded_bytes(double bytes, double seconds, const char* option)
{
    if (bytes <= most_recorded_bytes) return {};
    return fail(ErrorCode::budget_exceeded,
                fmt::format("{:g} s would hold {:.1f} GB in memory, and a session may hold {:.1f}: "
                            "give at most --seconds {:.0f}, or no {}",
                            seconds, 1e-9 * bytes, 1e-9 * most_recorded_bytes,
                            std::floor(seconds * most_recorded_bytes / bytes), option),
                option);
}

Status check_recordable(const Status& settings)
{
    if (settings) return settings;
    return fail(ErrorCode::invalid_argument,
                concat("this session could not be replayed: ", settings.error().message,
                       ": scale the model or its motion, or record nothing"),
                "--record");
}

double recorded_bytes(const TouchSettings& settings)
{
    const std::size_t tick =
        (settings.record ? sizeof(RecordedTick) : 0) + (settings.trace ? sizeof(TracedTick) : 0);
    return settings.seconds / settings.input.tick_seconds * static_cast<double>(tick);
}

Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& name, bool lists,
                                                     Session& session)
{
    auto model = std::make_unique<TouchModel>();
    const Stopwatch watch;
    const Status status = is_index_file(name) ? open_index(*model, name, session)
                                              : build_index_of(*model, name, lists, session);
    if (!status) return tl::unexpected(status.error());
    const auto with = [&] {
        const ProgressBar shown(session.progress(), session.bar());
        return with_exits(model->index, session.execution());
    }();
    if (!with) return at_model(with.error(), name);
    auto contact = IndexContactSurface::make(*with);
    if (!contact) return at_model(contact.error(), name);
    model->contact = std::move(*contact);
    model->reach = bounding_box(model->surface.mesh);
    model->build_seconds = watch.seconds();
    return model;
}

Result<TouchResult> touch_by_device(const TouchModel& model, const TouchSettings& settings,
                                    Session& session)
{
    auto opened = open_touch_device(settings.device, model.reach, model.surface.mesh,
                                    model.surface.topology, model.parts);
    if (!opened) return tl::unexpected(opened.error());
    Device& device = *opened->device;
    const DeviceLimits& limits = opened->limits;
    if (Status status = check_render_settings(opened->map, limits, settings.render); !status)
        return tl::unexpected(status.error());
    const auto parts = parts_for(model, settings.render, settings.law, session);
    if (!parts) return tl::unexpected(parts.error());
    std::optional<PatchTouch> patches;
    if (settings.patches) {
        patches.emplace(model, *settings.patches, opened->map, settings.render,
                        parts->normals.get(), settings.input.tick_seconds, settings.pace);
    }
    const double tick_seconds = settings.input.tick_seconds;
    const auto ticks = static_cast<std::uint64_t>(std::llround(settings.seconds / tick_seconds));
    const std::uint64_t release_ticks = ticks_to_release(device.info(), settings);
    // Before an engine is heard: an hour takes seconds to make.
    std::vector<RecordedTick> recorded_ticks(settings.record ? ticks + release_ticks : 0);
    std::vector<TracedTick> traced_ticks(settings.trace ? ticks + release_ticks : 0);
    std::unique_ptr<EngineLink> engine;
    std::unique_ptr<SceneMessageQueue> queue;
    if (!settings.engine.empty()) {
        auto transport = open_engine_transport(settings.engine);
        if (!transport) return tl::unexpected(transport.error());
        engine = std::make_unique<EngineLink>(std::move(*transport));
        if (settings.record) queue = std::make_unique<SceneMessageQueue>();
    }
    TouchRun run(model, *parts, opened->map, limits, settings.render,
                 {.engine = engine.get(), .recorded = queue.get()}, patches ? &*patches : nullptr);
    auto input = make_device_input(device.info(), settings.input);
    if (!input) return tl::unexpected(input.error());
    Recording recording;
    recording.settings = {.mesh_fingerprint = fingerprint_of(model),
                          .objects = objects_of(model),
                          .room = model.room,
                          .tick_seconds = tick_seconds,
                          .map = opened->map,
                          .render = run.renderer().options(),
                          .law = settings.law,
                          .max_force = limits.max_force,
                          .max_stiffness = limits.max_stiffness,
                          .max_damping = limits.max_damping};
    if (settings.record) {
        if (Status status = check_recordable(check_recording(recording)); !status)
            return tl::unexpected(status.error());
    }
    std::uint64_t last = ticks; // the session ends before this tick, and then lets go
    std::uint64_t count = 0;
    Snapshot<LiveTouch> live;
    std::atomic<bool> ended{false};
    ServoStatistics servo;
    const std::int64_t begin = nanoseconds_now();
    std::thread servo_thread([&] {
        servo = device.run(
            {.rate = 1 / tick_seconds, .ticks = ticks + release_ticks, .pace = settings.pace},
            [&](std::uint64_t number) noexcept {
                if (number < last && session.progress().cancelled()) last = number;
                if (number >= last) input->release();
                const double seconds = static_cast<double>(number) * tick_seconds;
                const DeviceState& state = input->accept(device.read());
                const RenderTick& rendered = run.tick(state, tick_seconds);
                if (settings.record) recorded_ticks[number] = recorded(seconds, state, rendered);
                if (settings.trace) traced_ticks[number] = traced(run.renderer());
                device.write(input->command(run.renderer()));
                if (engine != nullptr) engine->send(run.renderer(), state, nanoseconds_now());
                count = number + 1;
                live.writing() = {1e-9 * static_cast<double>(nanoseconds_now() - begin), count,
                                  rendered.force.norm(), rendered.hold, state.condition};
                live.publish();
                return count >= last + release_ticks ? Flow::stop : Flow::proceed;
            });
        ended.store(true);
    });
    const bool shown = session.bar() != BarMode::off && isatty(STDERR_FILENO) != 0;
    std::vector<SceneMessage> messages;
    const std::uint64_t events =
        show_live(live, *input, ended, shown, settings.graphics_rate, queue.get(), messages);
    servo_thread.join();

    TouchResult result = std::move(run).finish();
    result.law = settings.law;
    result.servo = std::move(servo);
    if (patches) {
        result.patches = patches->finish();
        result.patches->tick = result.render;
    }
    result.device = DeviceAccount{.info = device.info(),
                                  .limits = limits,
                                  .input = input->report(),
                                  .network = {},
                                  .hand = {},
                                  .button_events = events,
                                  .interrupted = last < ticks,
                                  .trouble = device.trouble()};
    if (engine != nullptr) {
        result.engine = {.name = engine->name(),
                         .report = engine->report(),
                         .trouble = engine->trouble(),
                         .dropped = queue != nullptr ? queue->dropped() : 0};
    }
    if (const auto* const udp = dynamic_cast<const UdpDevice*>(&device))
        result.device->network = udp->report();
    if (const auto* const held = dynamic_cast<const HandDevice*>(&device))
        result.device->hand = held->hand().model();
    traced_ticks.resize(settings.trace ? count : 0);
    result.trace = {tick_seconds, std::move(traced_ticks)};
    if (settings.record) {
        recorded_ticks.resize(count);
        recording.ticks = std::move(recorded_ticks);
        recording.messages = std::move(messages);
        result.recording = std::move(recording);
    }
    return result;
}

Result<ReplayResult> replay_touch(const TouchModel& model, const Recording& recording,
                                  const std::string& path, bool trace, Session& session)
{
    const RecordingSettings& settings = recording.settings;
    if (settings.mesh_fingerprint != fingerprint_of(model)) {
        return fail(ErrorCode::invalid_argument,
                    "was recorded with another model: replay it with the one that was touched",
                    path);
    }
    const DeviceLimits device = {.name = "recorded",
                                 .max_force = settings.max_force,
                                 .max_stiffness = settings.max_stiffness,
                                 .max_damping = settings.max_damping};
    if (Status status = check_render_settings(settings.map, device, settings.render); !status)
        return tl::unexpected(status.error());
    const auto parts = parts_for(model, settings.render, settings.law, session);
    if (!parts) return tl::unexpected(parts.error());
    TouchRun run(model, *parts, settings.map, device, settings.render,
                 {.replayed = recording.messages});
    ReplayResult result;
    std::vector<TracedTick> ticks;
    ticks.reserve(trace ? recording.ticks.size() : 0);
    const ProgressBar shown(session.progress(), session.bar());
    StageSteps steps(&session.progress(), "replaying the session", recording.ticks.size(), 64);
    for (const RecordedTick& tick : recording.ticks) {
        if (!steps.done(1)) return cancelled("replaying the session", path);
        const DeviceState state = device_state(tick);
        if (!same_response(tick,
                           recorded(tick.seconds, state, run.tick(state, settings.tick_seconds))))
            ++result.differences;
        if (trace) ticks.push_back(traced(run.renderer()));
    }
    if (const Status& status = run.replayed(); !status) {
        return fail(ErrorCode::malformed_file,
                    concat("what an engine sent does not fit the scene: ", status.error().message,
                           ": record the session again"),
                    path);
    }
    result.touch = std::move(run).finish();
    result.touch.trace = {settings.tick_seconds, std::move(ticks)};
    result.touch.law = settings.law;
    return result;
}

} // namespace proxima
