#include "cli/touch_input_report.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

Json info_json(const DeviceInfo& info, const DeviceLimits& limits)
{
    return {{"name", info.name},
            {"model", info.model},
            {"serial", info.serial},
            {"driver", info.driver},
            {"buttons", info.buttons},
            {"rotates", info.rotates},
            {"max_force", limits.max_force},
            {"max_stiffness", limits.max_stiffness},
            {"max_damping", limits.max_damping},
            {"workspace_radius", limits.workspace_radius}};
}

Json input_json(const InputReport& input)
{
    return {{"samples", input.samples},
            {"not_finite", input.not_finite},
            {"jumps", input.jumps},
            {"velocities", input.velocities},
            {"suspicions", input.suspicions},
            {"freezes", input.freezes},
            {"silences", input.silences},
            {"losses", input.losses},
            {"faulty_ticks", input.faulty_ticks},
            {"clutched_ticks", input.clutched_ticks},
            {"longest_fault", input.longest_fault},
            {"recoveries", input.recoveries},
            {"longest_recovery", input.longest_recovery}};
}

Json network_json(const UdpReport& network)
{
    return {{"received", network.received},
            {"accepted", network.accepted},
            {"malformed", network.malformed},
            {"foreign", network.foreign},
            {"duplicated", network.duplicated},
            {"reordered", network.reordered},
            {"leapt", network.leapt},
            {"lost", network.lost},
            {"late", network.late},
            {"sessions", network.sessions},
            {"replies", network.replies},
            {"unsent", network.unsent}};
}

/// Theory (simulated_hand.h): above this stiffness a wall with the session's damping oscillates by
/// itself, unless the hand damps it.
double stable_stiffness(const HandModel& hand, double damping)
{
    return (hand.device_damping + damping) / (hand.tick_seconds * (0.5 + hand.delay_ticks));
}

Json hand_json(const HandModel& hand, double damping)
{
    return {{"mass", hand.mass},
            {"stiffness", hand.hand_stiffness},
            {"damping", hand.hand_damping},
            {"device_damping", hand.device_damping},
            {"device_friction", hand.coulomb_friction},
            {"encoder_step", hand.encoder_step},
            {"delay", hand.delay_ticks},
            {"stable_stiffness", stable_stiffness(hand, damping)}};
}

std::string hand_text(const HandModel& hand, double damping)
{
    return fmt::format("hand: {:g} kg, pulled by {:g} N/m and {:g} N s/m; its device {:g} N s/m, "
                       "friction {:g} N, encoder step {:g} mm, forces {} ticks late; if "
                       "nobody held the device, walls stiffer than {:.4g} N/m would oscillate\n",
                       hand.mass, hand.hand_stiffness, hand.hand_damping, hand.device_damping,
                       hand.coulomb_friction, 1e3 * hand.encoder_step, hand.delay_ticks,
                       stable_stiffness(hand, damping));
}

std::string info_text(const DeviceInfo& info)
{
    std::string text = info.model;
    if (!info.serial.empty()) text += fmt::format(", number {}", info.serial);
    if (!info.driver.empty()) text += fmt::format(" ({})", info.driver);
    return text;
}

} // namespace

std::string device_text(const DeviceAccount& account, double damping)
{
    const InputReport& input = account.input;
    std::string text = fmt::format(
        "device: {}; at most {:g} N, {:g} N/m, {:g} N s/m; workspace radius {:g} mm\n"
        "input: {} samples; {} invalid positions, {} jumps, {} freezes, {} silences, {} losses; {} "
        "velocities corrected; {} ticks with implausible input, {:.3f} s at most\n",
        info_text(account.info), account.limits.max_force, account.limits.max_stiffness,
        account.limits.max_damping, 1e3 * account.limits.workspace_radius, input.samples,
        input.not_finite, input.jumps, input.freezes, input.silences, input.losses,
        input.velocities, input.faulty_ticks, input.longest_fault);
    if (input.recoveries > 0) {
        text += fmt::format("recovered {} times: full force at most {:.3f} s after the first good "
                            "sample\n",
                            input.recoveries, input.longest_recovery);
    }
    if (input.suspicions > input.freezes) {
        text += fmt::format("suspicion: the device reported the same position for more than half a "
                            "second while it was pushed, {} times; the force stayed\n",
                            input.suspicions - input.freezes);
    }
    if (account.hand) text += hand_text(*account.hand, damping);
    if (account.button_events > 0 || input.clutched_ticks > 0) {
        text += fmt::format("buttons: {} events, clutch open in {} ticks\n", account.button_events,
                            input.clutched_ticks);
    }
    if (account.network) {
        const UdpReport& n = *account.network;
        text += fmt::format(
            "packets: {} received, {} accepted; malformed {}, foreign {}, duplicated {}, "
            "reordered {}, leapt {}, late {}, lost {}\n",
            n.received, n.accepted, n.malformed, n.foreign, n.duplicated, n.reordered, n.leapt,
            n.late, n.lost);
    }
    if (account.interrupted) text += "stopped on request: the report covers the ticks until then\n";
    if (!account.trouble.empty()) text += fmt::format("trouble: {}\n", account.trouble);
    return text;
}

void add_device_json(Json& json, const DeviceAccount* account, double damping)
{
    const bool there = account != nullptr;
    json["device_info"] = there ? info_json(account->info, account->limits) : Json();
    json["hand"] = there && account->hand ? hand_json(*account->hand, damping) : Json();
    json["input"] = there ? input_json(account->input) : Json();
    json["network"] = there && account->network ? network_json(*account->network) : Json();
    json["button_events"] = there ? Json(account->button_events) : Json();
    json["interrupted"] = there && account->interrupted;
    json["trouble"] = there ? account->trouble : "";
}

std::string device_list_text(const std::vector<FoundDevice>& devices)
{
    std::string text;
    for (const FoundDevice& device : devices) {
        text +=
            device.info
                ? fmt::format("{}: {}; {:g} N, {:g} N/m, {:g} N s/m, {:g} mm\n", device.name,
                              info_text(*device.info), device.info->limits.max_force,
                              device.info->limits.max_stiffness, device.info->limits.max_damping,
                              1e3 * device.info->limits.workspace_radius)
                : fmt::format("{}: none: {}\n", device.name, device.problem);
    }
    return text +
           fmt::format("always: hand:SCRIPT ({}), udp:PORT, replay:FILE\n", hand_script_names());
}

Json device_list_json(const std::vector<FoundDevice>& devices)
{
    Json list = Json::array();
    for (const FoundDevice& device : devices) {
        list.push_back(device.info ? info_json(*device.info, device.info->limits)
                                   : Json{{"name", device.name}, {"problem", device.problem}});
    }
    return {{"devices", list}};
}

} // namespace proxima
