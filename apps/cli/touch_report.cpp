#include "cli/touch_report.h"

#include "cli/touch_engine.h"
#include "cli/touch_input_report.h"
#include "cli/touch_objects.h"
#include "cli/touch_options.h"
#include "cli/touch_texture.h"

#include <algorithm>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

std::string microseconds(const LatencyHistogram& histogram)
{
    const auto at = [&](double part) {
        return 1e-3 * static_cast<double>(histogram.quantile(part));
    };
    return fmt::format("p50 {:.2f}, p99 {:.2f}, p99.9 {:.2f}, p99.99 {:.2f}, max {:.2f} us",
                       at(0.5), at(0.99), at(0.999), at(0.9999), at(1));
}

double percent(std::uint64_t part, std::uint64_t whole)
{
    return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

std::string times(std::uint64_t count)
{
    return count == 1 ? std::string("once") : fmt::format("{} times", count);
}

/// Where a device does not have what was asked for.
std::string less_text(const char* what, const char* unit, double asked, double used)
{
    if (!(used < asked)) return {};
    return fmt::format("{}: {:g} {} of the {:g} asked for, more than the device allows: "
                       "--limits names a stronger one for a hand\n",
                       what, used, unit, asked);
}

} // namespace

Json latency_json(const LatencyHistogram& histogram)
{
    return {{"p50_ns", histogram.quantile(0.5)},
            {"p99_ns", histogram.quantile(0.99)},
            {"p99_9_ns", histogram.quantile(0.999)},
            {"p99_99_ns", histogram.quantile(0.9999)},
            {"max_ns", histogram.max()}};
}

std::string swings_text(const SwingReport& swings, Guard guard, std::uint64_t ticks, double seconds)
{
    const bool observes = guard == Guard::observe;
    const double tick_seconds = seconds / static_cast<double>(std::max<std::uint64_t>(ticks, 1));
    std::string text;
    if (swings.swings > 0) {
        text += fmt::format(
            "walls: contacts swung without fading, {}; the guard {} damping of up to {:.3g} "
            "N s/m, for {:.1f} s in all\n",
            times(swings.swings), observes ? "would have added" : "added", swings.most_damping,
            tick_seconds * static_cast<double>(swings.damped_ticks));
    }
    if (swings.softenings > 0) {
        text += fmt::format(
            "walls: contacts went on swinging, {}; the guard {} the force, down to {:.3g} of "
            "it, for {:.1f} s at most and {:.1f} s in all. Less stiffness or more damping helps: "
            "see \"Walls that are too stiff\" in docs/devices.md\n",
            times(swings.softenings), observes ? "would have softened" : "softened",
            swings.lowest_softness, swings.longest_softening,
            tick_seconds * static_cast<double>(swings.softened_ticks));
    }
    return text;
}

void add_swings_json(Json& json, const SwingReport& swings, Guard guard)
{
    json["guard"] = guard_name(guard);
    json["damped_ticks"] = swings.damped_ticks;
    json["softened_ticks"] = swings.softened_ticks;
    json["lowest_softness"] = swings.lowest_softness;
    json["swings"] = swings.swings;
    json["softenings"] = swings.softenings;
    json["most_damping"] = swings.most_damping;
    json["longest_softening"] = swings.longest_softening;
    json["most_given"] = swings.most_given;
}

/// From the first tick to the last; 0 where there is one at most.
double ticks_per_second(const ServoStatistics& servo)
{
    if (servo.ticks < 2) return 0;
    return static_cast<double>(servo.ticks - 1) / std::max(servo.seconds, 1e-9);
}

namespace {

/// What went on in the forces, for who looks for the reason of something.
std::string counters_text(const TouchModel& model, const TouchResult& result)
{
    const QualityReport& quality = result.quality;
    const Vec3& center = result.map.center;
    return fmt::format(
        "workspace: 1 m of the device is {:.6g} of the model, its center ({:.6g}, {:.6g}, {:.6g}); "
        "ready in {:.3f} s\n"
        "sticking {:.1f} %, speed at most {:.2f} m/s; ticks that ran out of moves {}, of memory "
        "{}, "
        "had faulty input {}\n"
        "largest change of force in a tick: {:.3f} of what the motion explains (above 1: a jump), "
        "{:.1f} degrees of turn; energy lost to friction and damping {:.3g} J\n"
        "guards: force limited in {} ticks, its change in {}\n",
        result.map.units_per_metre, center.x(), center.y(), center.z(), model.build_seconds,
        percent(quality.sticking_ticks, quality.ticks), quality.max_speed, quality.limited_ticks,
        quality.overloaded_ticks, quality.faulty_ticks, quality.max_step_ratio,
        quality.max_turn_degrees, quality.taken_energy, result.clamped, result.slewed);
}

/// The guards that did something, in a line; empty where all was calm.
std::string guards_text(const TouchResult& result)
{
    std::string text;
    const auto add = [&](std::uint64_t ticks, const char* what) {
        if (ticks > 0) text += fmt::format("{}{} in {}", text.empty() ? "" : ", ", what, ticks);
    };
    add(result.quality.limited_ticks, "moves cut short");
    add(result.quality.overloaded_ticks, "memory full");
    add(result.quality.faulty_ticks, "input faulty");
    add(result.clamped, "force limited");
    add(result.slewed, "its change limited");
    return text.empty() ? text : fmt::format("of {} ticks: {}\n", result.quality.ticks, text);
}

std::string servo_text(const ServoStatistics& servo, bool verbose)
{
    std::string text =
        fmt::format("servo: {:.1f} Hz, {} deadlines missed", ticks_per_second(servo), servo.missed);
    if (!verbose) {
        return text + (servo.note.empty() ? std::string("\n") : fmt::format("; {}\n", servo.note));
    }
    text +=
        fmt::format(" ({} because the thread woke late, {} because of work), {} ticks left out, {} "
                    "page faults\n"
                    "woken late by: {}\nwhole tick: {}\n"
                    "real-time priority: {}, locked memory: {}\n",
                    servo.overslept, servo.missed - servo.overslept, servo.skipped,
                    servo.page_faults, microseconds(servo.late), microseconds(servo.work),
                    servo.real_time_priority ? "yes" : "no", servo.locked_memory ? "yes" : "no");
    return servo.note.empty() ? text : text + fmt::format("note: {}\n", servo.note);
}

} // namespace

std::string touch_text(const TouchReportOf& of, const TouchModel& model, const TouchResult& result)
{
    const QualityReport& quality = result.quality;
    const RenderOptions& render = result.render_options;
    std::string text =
        fmt::format("{}: {} triangles\n"
                    "{}: {} ticks by {}, {}, radius {:g} m\n"
                    "touching {:.1f} %; force at most {:.3f} N, depth {:.2f} mm\n"
                    "passed through the surface {}\n",
                    of.model, model.surface.mesh.triangle_count(), of.device, quality.ticks,
                    result.law == ForceLaw::penalty ? "penalty forces" : "a proxy",
                    in_words(SurfaceMaterial{render.force.stiffness, render.force.damping,
                                             render.static_friction, render.dynamic_friction}),
                    render.proxy_radius, percent(quality.touching_ticks, quality.ticks),
                    quality.max_force, 1e3 * quality.max_depth, times(quality.passes));
    text += of.verbose ? counters_text(model, result) : guards_text(result);
    text += swings_text(result.swings, render.guard, quality.ticks, result.session_seconds);
    text += texture_text(render.texture, result.texture);
    text += fmt::format("computing a force: {}\n", microseconds(result.render));
    text += objects_text(model, quality);
    text += engine_text(result);
    text += less_text("stiffness", "N/m", of.asked.stiffness, render.force.stiffness);
    text += less_text("damping", "N s/m", of.asked.damping, render.force.damping);
    if (result.device) {
        const DeviceAccount& device = *result.device;
        if (of.verbose || device.input.faulty_ticks + device.input.suspicions > 0 ||
            !device.trouble.empty())
            text += device_text(device, render.force.damping);
    }
    if (of.differences) {
        text += fmt::format("replayed: {} ticks differ from the recording\n", *of.differences);
    } else if (of.paced) {
        text += servo_text(result.servo, of.verbose);
    }
    return text;
}

Json touch_json(const TouchReportOf& of, const TouchModel& model, const TouchResult& result)
{
    const QualityReport& quality = result.quality;
    const RenderOptions& render = result.render_options;
    const Vec3& center = result.map.center;
    Json json = {{"model", of.model},
                 {"triangles", model.surface.mesh.triangle_count()},
                 {"device", of.device},
                 {"build_seconds", model.build_seconds},
                 {"units_per_metre", result.map.units_per_metre},
                 {"center", {center.x(), center.y(), center.z()}},
                 {"stiffness", render.force.stiffness},
                 {"damping", render.force.damping},
                 {"static_friction", render.static_friction},
                 {"dynamic_friction", render.dynamic_friction},
                 {"radius", render.proxy_radius},
                 {"shading", render.shading == ForceShading::on},
                 {"force", result.law == ForceLaw::penalty ? "penalty" : "proxy"},
                 {"ticks", quality.ticks},
                 {"touching_ticks", quality.touching_ticks},
                 {"sticking_ticks", quality.sticking_ticks},
                 {"passes", quality.passes},
                 {"limited_ticks", quality.limited_ticks},
                 {"overloaded_ticks", quality.overloaded_ticks},
                 {"faulty_ticks", quality.faulty_ticks},
                 {"moving_ticks", quality.moving_ticks},
                 {"squeezed_ticks", quality.squeezed_ticks},
                 {"max_force", quality.max_force},
                 {"max_spring", quality.max_spring},
                 {"max_depth", quality.max_depth},
                 {"max_speed", quality.max_speed},
                 {"max_step_ratio", quality.max_step_ratio},
                 {"max_turn_degrees", quality.max_turn_degrees},
                 {"taken_energy", quality.taken_energy},
                 {"max_moves", quality.max_moves},
                 {"clamped_ticks", result.clamped},
                 {"slewed_ticks", result.slewed}};
    add_swings_json(json, result.swings, render.guard);
    json["texture"] = texture_json(render.texture);
    json["texture_report"] = texture_json(result.texture);
    json["tick"] = latency_json(result.render);
    for (const char* const name : {"servo", "replay_differences", "patches"}) json[name] = nullptr;
    json["objects"] = objects_json(model, quality);
    json["engine"] = engine_json(result);
    add_device_json(json, result.device ? &*result.device : nullptr, render.force.damping);
    if (of.differences) {
        json["replay_differences"] = *of.differences;
    } else if (of.paced) {
        json["servo"] = {{"seconds", result.servo.seconds},
                         {"missed_deadlines", result.servo.missed},
                         {"overslept", result.servo.overslept},
                         {"page_faults", result.servo.page_faults},
                         {"skipped_ticks", result.servo.skipped},
                         {"late", latency_json(result.servo.late)},
                         {"work", latency_json(result.servo.work)},
                         {"real_time_priority", result.servo.real_time_priority},
                         {"locked_memory", result.servo.locked_memory},
                         {"note", result.servo.note}};
    }
    return json;
}

} // namespace proxima
