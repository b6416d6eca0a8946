#include "cli/touch_self_test.h"

#include "base/text.h"
#include "cli/stderr_text.h"
#include "cli/touch_self_test_report.h"
#include "haptics/device/self_test.h"
#include "haptics/device/self_test_report.h"
#include "lab/self_test_hand.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <string>
#include <thread>
#include <unistd.h>

namespace proxima {

namespace {

/// What a self-test uses, beside options of every command.
constexpr std::array used_options = {"--self-test",       "--yes",
                                     "--device",          "--device-library",
                                     "--limits",          "--free-running",
                                     "--hand-mass",       "--hand-stiffness",
                                     "--hand-damping",    "--device-damping",
                                     "--device-friction", "--encoder-step",
                                     "--delay",           "--json",
                                     "--threads",         "--simd",
                                     "--quiet",           "--progress"};

using Clock = std::chrono::steady_clock;

/// Where a person sits before a terminal, and says when to go on.
bool is_interactive(const TouchCommandOptions& options)
{
    return !options.yes && options.device != self_test_hand && isatty(STDIN_FILENO) != 0;
}

/// Whether a line was entered. Waits 50 ms at most.
bool entered_line()
{
    pollfd input = {STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 50) <= 0 || (input.revents & (POLLIN | POLLHUP)) == 0) return false;
    std::array<char, 256> line{};
    return read(STDIN_FILENO, line.data(), line.size()) >= 0;
}

std::string instruction(const SelfTest& test, bool interactive)
{
    const SelfTestOptions& options = test.options();
    std::string go;
    if (interactive) {
        go = " Press Enter to begin.";
    } else if (options.prepare_seconds > 0) {
        go = fmt::format(" Begin in {:g} s.", options.prepare_seconds);
    }
    switch (test.step()) {
    case SelfTestStep::slow:
        return fmt::format(
            "1 of 4  Hold the tip lightly in the middle of its workspace. Then move it slowly, "
            "about a\n"
            "        centimetre a second, left and right, up and down, to and fro, for {:g} s.{}\n",
            options.slow_seconds, go);
    case SelfTestStep::fast:
        return fmt::format(
            "2 of 4  Move it fast: loops as large as a saucer, two a second, for {:g} s.{}\n",
            options.fast_seconds, go);
    case SelfTestStep::release:
        return fmt::format("3 of 4  Bring it back to the middle, let go, and keep your hands off "
                           "until the end. It has\n"
                           "        to stay where it is.{}\n",
                           go);
    case SelfTestStep::rest:
        return fmt::format(
            "4 of 4  Do not touch it. The motors push it, by a few millimetres and with {:.2g} N "
            "at most.\n",
            test.largest_force());
    default:
        return {};
    }
}

/// Tells the person what to do, until `ended`, and the test when the person is ready.
void guide(SelfTest& test, const std::atomic<bool>& ended, bool interactive, bool shown)
{
    SelfTestStep told = SelfTestStep::waiting;
    while (!ended.load()) {
        const SelfTestStep now = test.step();
        if (now != told && shown) {
            write_stderr(instruction(test, interactive));
        }
        told = now;
        if (interactive && test.prepares()) {
            if (entered_line() && test.step() == told) test.confirm();
        } else {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
}

std::string fault_text(SelfTestFault fault, const SelfTestOptions& options)
{
    switch (fault) {
    case SelfTestFault::no_sample:
        return fmt::format(
            "no position came within {:g} s: check that the device is switched on, or that its "
            "program sends",
            options.wait_seconds);
    case SelfTestFault::not_finite:
        return "the device reported a position that is not a number, or metres away: it has to be "
               "calibrated, "
               "or its driver is faulty";
    case SelfTestFault::jumped:
        return "the position jumped by more than 50 mm between two samples: calibrate the device, "
               "and check "
               "its cable";
    case SelfTestFault::refused:
        return "the driver stopped the force or distrusts its input: let it cool down, and run the "
               "driver's "
               "own test";
    case SelfTestFault::silent:
        return fmt::format(
            "no new position came for {:g} s, or gaps kept interrupting the motors: check cable "
            "and connection",
            options.most_silence);
    case SelfTestFault::gone:
        return "the driver lost the device: check its plug";
    case SelfTestFault::left:
        return "the device's program ended the session: start it again for the whole test, 2 "
               "minutes";
    case SelfTestFault::none:
    case SelfTestFault::cancelled:
        break;
    }
    return "the driver stopped calling before the test was done: check that the device is plugged "
           "in";
}

} // namespace

void add_self_test_options(CLI::App& parser, TouchCommandOptions& options)
{
    // Nothing is touched then.
    parser.add_flag_callback(
        "--self-test",
        [&parser, &options] {
            options.self_test = true;
            parser.get_option("MODEL")->required(false);
        },
        "Measure the device instead of touching a model: rate, encoder step, friction, mass, "
        "delay; "
        "and say what to set");
    parser.add_flag("--yes", options.yes,
                    "Self-test: do not wait for Enter, begin each step after 3 s");
}

Status check_self_test_options(const TouchCommandOptions& options)
{
    if (!options.self_test) {
        if (options.yes)
            return fail(ErrorCode::invalid_argument, "is for --self-test: leave it out", "--yes");
        if (options.device == self_test_hand) {
            return fail(ErrorCode::invalid_argument,
                        "is the hand of --self-test: use it with that, or another script",
                        std::string(self_test_hand));
        }
        return {};
    }
    for (const std::string& name : options.given) {
        if (std::ranges::find(used_options, name) != used_options.end()) continue;
        return fail(ErrorCode::invalid_argument, "is not used by a self-test: leave it out", name);
    }
    const bool other_hand = options.device.starts_with("hand:") && options.device != self_test_hand;
    if (other_hand || options.device.starts_with("replay:")) {
        return fail(
            ErrorCode::invalid_argument,
            concat("has nobody who follows instructions: test ", self_test_hand, " or a device"),
            options.device);
    }
    return {};
}

Status run_self_test(const TouchCommandOptions& options, Session& session)
{
    const TouchSettings settings = settings_of(options);
    const bool simulated = options.device == self_test_hand;
    DeviceLimits limits = settings.device.limits.value_or(*find_device("omni"));
    std::unique_ptr<Device> device;
    SelfTestHand* hand = nullptr;
    if (simulated) {
        auto made = std::make_unique<SelfTestHand>(options.device, options.hand, limits);
        hand = made.get();
        device = std::move(made);
    } else {
        auto opened = open_device(options.device, {.library = options.library, .limits = limits});
        if (!opened) return tl::unexpected(opened.error());
        device = std::move(*opened);
        limits = device->info().limits;
        if (settings.device.limits) limits = within(limits, *settings.device.limits);
    }
    const bool interactive = is_interactive(options);
    SelfTestOptions test_options;
    test_options.tick_seconds = settings.input.tick_seconds;
    // Nobody hurries a person who is to press Enter.
    if (interactive) test_options.prepare_seconds = 3600;
    if (simulated) test_options.prepare_seconds = 0;
    DeviceInfo info = device->info();
    info.limits = limits;
    auto test = SelfTest::make(info, test_options);
    if (!test) return tl::unexpected(test.error());
    if (hand != nullptr) hand->follow(*test);

    ServoStatistics servo;
    std::atomic<bool> ended{false};
    const Clock::time_point begin = Clock::now();
    std::thread servo_thread([&] {
        servo = device->run(
            {.rate = 1 / test_options.tick_seconds, .pace = settings.pace},
            [&](std::uint64_t number) noexcept {
                if (session.progress().cancelled()) test->cancel();
                const DeviceReading reading = device->read();
                const double now = std::chrono::duration<double>(Clock::now() - begin).count();
                const double seconds =
                    simulated ? static_cast<double>(number) * test_options.tick_seconds : now;
                device->write(test->tick(reading, seconds, now));
                return test->has_ended() ? Flow::stop : Flow::proceed;
            });
        ended.store(true);
    });
    // A simulated hand needs no words; on a terminal they show what goes on.
    const bool shown = !session.options().quiet && (!simulated || isatty(STDERR_FILENO) != 0);
    guide(*test, ended, interactive, shown);
    servo_thread.join();

    if (Status status = session.check_running(); !status) return status;
    if (test->fault() != SelfTestFault::none || test->step() != SelfTestStep::finished) {
        const std::string trouble = device->trouble();
        return fail(ErrorCode::invalid_argument,
                    concat(fault_text(test->fault(), test_options),
                           trouble.empty() ? "" : concat("; ", trouble)),
                    options.device);
    }
    const SelfTestPage page = {.info = info,
                               .limits = limits,
                               .report = report_of(*test, limits),
                               .options = test_options,
                               .servo = std::move(servo),
                               .paced = settings.pace != Pace::unpaced};
    session.print(self_test_text(page));
    return session.write_json(self_test_json(page));
}

} // namespace proxima
