#include "cli/touch_self_test_report.h"

#include "cli/text_table.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

std::string_view word_of(StepKind kind)
{
    switch (kind) {
    case StepKind::grid:
        return "grid";
    case StepKind::uneven:
        return "uneven";
    case StepKind::invisible:
        return "invisible";
    case StepKind::unknown:
        break;
    }
    return "unknown";
}

std::string_view word_of(SelfTestOutcome outcome)
{
    switch (outcome) {
    case SelfTestOutcome::not_done:
        return "not_done";
    case SelfTestOutcome::complete:
        return "complete";
    case SelfTestOutcome::unmoved:
        return "unmoved";
    case SelfTestOutcome::too_far:
        return "too_far";
    case SelfTestOutcome::no_rest:
        return "no_rest";
    case SelfTestOutcome::too_weak:
        break;
    }
    return "too_weak";
}

std::string_view word_of(StiffnessLimit limit)
{
    switch (limit) {
    case StiffnessLimit::delay:
        return "delay";
    case StiffnessLimit::encoder:
        return "encoder";
    case StiffnessLimit::device:
        break;
    }
    return "device";
}

std::string step_text(const EncoderStep& encoder)
{
    switch (encoder.kind) {
    case StepKind::grid:
        return fmt::format("{:.4g}", 1e3 * encoder.step);
    case StepKind::uneven:
        return fmt::format("about {:.2g}", 1e3 * encoder.step);
    case StepKind::invisible:
        return fmt::format("none above {:.1g}", 1e3 * encoder.least_change);
    case StepKind::unknown:
        break;
    }
    return "hardly moved";
}

std::string fitted_text(const MotionFit& motion, const Fitted& fitted)
{
    if (!motion.found) return "-";
    if (!fitted.is_certain())
        return fmt::format("below {:.2g}", std::max(fitted.value + 4 * fitted.error, 1e-3));
    return fmt::format("{:.3g}", fitted.value);
}

std::string breakaway_text(const AxisReport& axis, double largest_force)
{
    if (axis.static_friction) return fmt::format("{:.3f}", *axis.static_friction);
    const bool unmoved =
        std::ranges::find(axis.ramps, SelfTestOutcome::unmoved) != axis.ramps.end();
    return unmoved ? fmt::format("above {:.2f}", largest_force) : "-";
}

std::string delay_text(const MotionFit& motion)
{
    if (motion.is_later) return fmt::format("{} or more", motion.least_delay);
    if (!motion.found) return "-";
    if (motion.least_delay == motion.most_delay) return std::to_string(motion.delay);
    return fmt::format("{} to {}", motion.least_delay, motion.most_delay);
}

std::string table_text(const SelfTestReport& report)
{
    TextTable table({"", "x", "y", "z"});
    const auto add = [&](const char* name,
                         const std::function<std::string(const AxisReport&)>& cell) {
        std::vector<std::string> row{name};
        for (const AxisReport& axis : report.axes) row.push_back(cell(axis));
        table.add_row(row);
    };
    add("encoder step, mm", [](const AxisReport& axis) { return step_text(axis.encoder); });
    add("noise at rest, mm", [](const AxisReport& axis) {
        return axis.noise < 1e-10 ? std::string("0") : fmt::format("{:.2g}", 1e3 * axis.noise);
    });
    add("friction at rest, N",
        [&](const AxisReport& axis) { return breakaway_text(axis, report.largest_force); });
    add("friction in motion, N",
        [](const AxisReport& axis) { return fitted_text(axis.motion, axis.motion.friction); });
    add("weight left over, N", [](const AxisReport& axis) {
        return axis.static_friction ? fmt::format("{:.3f}", axis.weight) : std::string("-");
    });
    add("damping, N s/m",
        [](const AxisReport& axis) { return fitted_text(axis.motion, axis.motion.damping); });
    add("mass, kg",
        [](const AxisReport& axis) { return fitted_text(axis.motion, axis.motion.mass); });
    add("delay, ticks", [](const AxisReport& axis) { return delay_text(axis.motion); });
    return table.text();
}

std::string timing_text(const SelfTestPage& page)
{
    if (!page.paced) return "rate: not measured: the ticks ran without waiting\n";
    const SampleTiming& timing = page.report.timing;
    std::string text =
        fmt::format("rate: {:.1f} new samples a second; {:.3f} ms apart, deviation {:.3f}, 99 % "
                    "within {:.2f}, longest "
                    "{:.2f} ms\n",
                    timing.sample_rate, 1e3 * timing.mean_interval, 1e3 * timing.interval_deviation,
                    1e3 * timing.interval_p99, 1e3 * timing.longest_interval);
    text += fmt::format("      {} of {} ticks had no new sample; {} deadlines missed",
                        timing.ticks - timing.samples, timing.ticks, page.servo.missed);
    if (timing.repeated) {
        text += fmt::format("; {:.1f} % of samples in fast motion repeat the one before",
                            100 * *timing.repeated);
    }
    return text + "\n";
}

/// What could not be measured, and why.
std::string gaps_text(const SelfTestPage& page)
{
    const SelfTestReport& report = page.report;
    std::string text;
    const auto any_axis = [&](SelfTestOutcome outcome) {
        return std::ranges::any_of(report.axes, [&](const AxisReport& axis) {
            return std::ranges::find(axis.ramps, outcome) != axis.ramps.end() ||
                   std::ranges::find(axis.pushes, outcome) != axis.pushes.end();
        });
    };
    if (!report.rested) {
        return "The tip did not rest after it was let go, so the motors did nothing: no friction, "
               "mass or delay. "
               "Let it\nhang or lie so that it stays, switch gravity compensation on, and "
               "repeat.\n";
    }
    if (report.held) {
        text += "Something held the tip while the motors pushed: friction, damping and mass "
                "include it. Let go "
                "and repeat.\n";
    }
    if (any_axis(SelfTestOutcome::unmoved)) {
        text += fmt::format(
            "Up to {:.2f} N did not move the tip everywhere: it was held, it stood at a stop, its "
            "forces are off, or its\nprogram makes forces of planes alone.\n",
            report.largest_force);
    }
    if (any_axis(SelfTestOutcome::no_rest))
        text += "The tip did not come to rest between pushes: some numbers are missing.\n";
    if (any_axis(SelfTestOutcome::too_far)) {
        text += fmt::format("A push was stopped because the tip went farther than {:g} mm or "
                            "faster than {:g} m/s.\n",
                            1e3 * page.options.most_travel, page.options.most_speed);
    }
    if (page.report.timing.repeated && *page.report.timing.repeated > 0.05) {
        text += fmt::format(
            "The device measures less often than it is asked: about {:.0f} times a second.\n",
            (1 - *page.report.timing.repeated) * page.report.timing.sample_rate);
    }
    return text;
}

std::string settings_text(const SelfTestPage& page)
{
    if (!page.report.settings) {
        return page.report.any_is_later()
                   ? "No settings: how late forces act is not known, and it may be 80 ticks or "
                     "more. Find what delays\nthem, such as a network, or what hides them, such as "
                     "noise.\n"
                   : "No settings: how forces move the tip is not known.\n";
    }
    const SuggestedSettings& set = *page.report.settings;
    std::string text =
        fmt::format("Set --stiffness {:g} --damping {:.2g}. A wall may have at most\n",
                    set.stiffness, set.damping);
    const auto limit = [&](double stiffness, const char* why, bool binds) {
        text += fmt::format("  {:>7.4g} N/m  {}{}\n", stiffness, why,
                            binds ? "  <- a fifth below this" : "");
    };
    text += fmt::format("  {:>7.4g} N/m  by the device's maker{}\n", set.by_device,
                        set.limit == StiffnessLimit::device ? "  <- this" : "");
    limit(set.by_delay, "(b + B) / (T / 2 + delay): stiffer walls oscillate by themselves",
          set.limit == StiffnessLimit::delay);
    if (set.by_encoder) {
        limit(*set.by_encoder, "2 friction / encoder step: stiffer walls buzz by a step",
              set.limit == StiffnessLimit::encoder);
    }
    if (set.passive) {
        text += fmt::format("{:g} N/m, 2 b / T, is the limit for a wall without damping that never "
                            "gives energy to any "
                            "hand.\n",
                            std::floor(*set.passive));
    }
    return text;
}

/// Options that simulate this device, in a hand of no mass.
std::string simulation_text(const SelfTestReport& report)
{
    double mass = 0;
    double damping = 0;
    double friction = 0;
    double found = 0;
    for (const AxisReport& axis : report.axes) {
        if (!axis.motion.found) continue;
        found += 1;
        mass += axis.motion.mass.value;
        damping += axis.motion.damping.value;
        friction += axis.motion.friction.value;
    }
    if (!(found > 0) || report.any_is_later()) return {};
    return fmt::format("Such a device, simulated: --hand-mass {:.2g} --device-damping {:.2g} "
                       "--device-friction {:.2g} --encoder-step {:.2g} --delay {}\n",
                       mass / found, damping / found, friction / found, report.step, report.delay);
}

Json fitted_json(const MotionFit& motion, const Fitted& fitted)
{
    if (!motion.found) return nullptr;
    return {{"value", fitted.value}, {"error", fitted.error}};
}

template <class T>
Json optional_json(const std::optional<T>& value)
{
    return value ? Json(*value) : Json(nullptr);
}

Json delay_range_json(const MotionFit& motion)
{
    if (motion.is_later) return {motion.least_delay, nullptr};
    return motion.found ? Json{motion.least_delay, motion.most_delay} : Json(nullptr);
}

Json axis_json(const AxisReport& axis)
{
    const MotionFit& motion = axis.motion;
    const Json none = nullptr;
    return {{"encoder", word_of(axis.encoder.kind)},
            {"encoder_step", axis.encoder.step},
            {"noise", axis.noise},
            {"noise_range", axis.noise_range},
            {"ramps", {word_of(axis.ramps[0]), word_of(axis.ramps[1])}},
            {"breakaway", {optional_json(axis.breakaway[0]), optional_json(axis.breakaway[1])}},
            {"static_friction", optional_json(axis.static_friction)},
            {"weight", axis.static_friction ? Json(axis.weight) : none},
            {"pushes", {word_of(axis.pushes[0]), word_of(axis.pushes[1])}},
            {"mass", fitted_json(motion, motion.mass)},
            {"damping", fitted_json(motion, motion.damping)},
            {"friction", fitted_json(motion, motion.friction)},
            {"held_stiffness", fitted_json(motion, motion.stiffness)},
            {"delay", motion.found ? Json(motion.delay) : none},
            {"delay_range", delay_range_json(motion)},
            {"residual", motion.found ? Json(motion.residual) : none}};
}

} // namespace

std::string self_test_text(const SelfTestPage& page)
{
    const DeviceLimits& limits = page.limits;
    std::string text =
        fmt::format("device: {}{}; at most {:g} N, {:g} N/m, {:g} N s/m, says its maker\n",
                    page.info.model, page.info.serial.empty() ? "" : ", number " + page.info.serial,
                    limits.max_force, limits.max_stiffness, limits.max_damping);
    text += timing_text(page);
    text += "\n" + table_text(page.report) + "\n";
    text += settings_text(page);
    text += simulation_text(page.report);
    text += gaps_text(page);
    text += fmt::format(
        "Newtons are those that were commanded, at most {:.2g} in this test: a device that gives "
        "half "
        "seems to have\ntwice the mass and friction. A hand adds its own mass and damping.\n",
        page.report.largest_force);
    return text;
}

Json self_test_json(const SelfTestPage& page)
{
    const SelfTestReport& report = page.report;
    const SampleTiming& timing = report.timing;
    const Json none = nullptr;
    Json json = {{"device", page.info.name},
                 {"model", page.info.model},
                 {"serial", page.info.serial},
                 {"driver", page.info.driver},
                 {"max_force", page.limits.max_force},
                 {"max_stiffness", page.limits.max_stiffness},
                 {"max_damping", page.limits.max_damping},
                 {"largest_force", report.largest_force},
                 {"ticks", page.servo.ticks},
                 {"missed_deadlines", page.servo.missed},
                 {"sample_rate", page.paced ? Json(timing.sample_rate) : none},
                 {"mean_interval", page.paced ? Json(timing.mean_interval) : none},
                 {"interval_deviation", page.paced ? Json(timing.interval_deviation) : none},
                 {"interval_p99", page.paced ? Json(timing.interval_p99) : none},
                 {"longest_interval", page.paced ? Json(timing.longest_interval) : none},
                 {"ticks_without_sample", timing.ticks - timing.samples},
                 {"repeated_part", optional_json(timing.repeated)},
                 {"rested", report.rested},
                 {"held", report.held}};
    constexpr std::array names = {"x", "y", "z"};
    for (std::size_t i = 0; i < names.size(); ++i)
        json["axes"][names[i]] = axis_json(report.axes[i]);
    if (!report.settings) {
        json["settings"] = nullptr;
        return json;
    }
    const SuggestedSettings& set = *report.settings;
    json["settings"] = {{"stiffness", set.stiffness},
                        {"damping", set.damping},
                        {"limit", word_of(set.limit)},
                        {"by_device", set.by_device},
                        {"by_delay", set.by_delay},
                        {"by_encoder", optional_json(set.by_encoder)},
                        {"passive", optional_json(set.passive)}};
    return json;
}

} // namespace proxima
