#include "haptics/device/hd_device.h"

#include "base/shared_library.h"
#include "base/text.h"
#include "haptics/loop/tick_account.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace proxima {

namespace {

// Types and values of the HD API that we use, by its public reference.
using HdHandle = unsigned int;
using HdEnum = unsigned int;
using HdCallback = unsigned int (*)(void*);
using HdCallbackHandle = unsigned long;

struct HdError {
    unsigned int code = 0;
    int internal_code = 0;
    HdHandle device = 0;
};

constexpr HdHandle invalid_handle = 0xFFFFFFFF;
constexpr unsigned int callback_done = 0;
constexpr unsigned int callback_continue = 1;
constexpr unsigned short highest_priority = 0xFFFF;
constexpr HdEnum current_buttons = 0x2000;
constexpr HdEnum current_velocity = 0x2051;
constexpr HdEnum current_transform = 0x2052;
constexpr HdEnum current_force = 0x2700;
constexpr HdEnum api_version = 0x2500;
constexpr HdEnum model_type = 0x2501;
constexpr HdEnum driver_version = 0x2502;
constexpr HdEnum vendor = 0x2503;
constexpr HdEnum serial_number = 0x2504;
constexpr HdEnum usable_workspace = 0x2551;
constexpr HdEnum calibration_style = 0x2555;
constexpr HdEnum nominal_max_stiffness = 0x2602;
constexpr HdEnum nominal_max_force = 0x2603;
constexpr HdEnum nominal_max_damping = 0x2609;
constexpr HdEnum force_output = 0x4000;
constexpr HdEnum calibration_needs_update = 0x5001;
constexpr HdEnum calibration_needs_hands = 0x5002;
/// Errors of forces: too large, too sudden, too fast, motors too warm. The driver stops the force.
constexpr unsigned int first_force_error = 0x0200;
constexpr unsigned int last_force_error = 0x0204;
/// Errors of devices, from 0x0300 on: faults and lost connections.
constexpr unsigned int last_device_error = 0x03FF;

/// Hz: the driver's, unless it is given another one that it has.
constexpr double usual_rate = 1000;
constexpr double rest_seconds = 0.5; ///< after an error of forces
constexpr double millimetre = 1e-3;
constexpr const char* hd_advice =
    "install OpenHaptics 3.4 and 3D Systems' driver of the device, or name the library by "
    "--device-library";

/// The functions of libHD.
struct HdApi {
    HdHandle (*init_device)(const char*) = nullptr;
    void (*disable_device)(HdHandle) = nullptr;
    void (*make_current_device)(HdHandle) = nullptr;
    void (*begin_frame)(HdHandle) = nullptr;
    void (*end_frame)(HdHandle) = nullptr;
    HdError (*get_error)() = nullptr;
    const char* (*get_error_string)(unsigned int) = nullptr;
    void (*enable)(HdEnum) = nullptr;
    void (*disable)(HdEnum) = nullptr;
    void (*get_integers)(HdEnum, int*) = nullptr;
    void (*get_doubles)(HdEnum, double*) = nullptr;
    void (*set_doubles)(HdEnum, const double*) = nullptr;
    const char* (*get_string)(HdEnum) = nullptr;
    void (*set_rate)(unsigned long) = nullptr;
    void (*start_scheduler)() = nullptr;
    void (*stop_scheduler)() = nullptr;
    HdCallbackHandle (*schedule)(HdCallback, void*, unsigned short) = nullptr;
    void (*unschedule)(HdCallbackHandle) = nullptr;
    HdEnum (*check_calibration)() = nullptr;      ///< may be missing
    void (*update_calibration)(HdEnum) = nullptr; ///< may be missing
};

Result<HdApi> load_hd_api(const SharedLibrary& library)
{
    HdApi api;
    SymbolTable table(library);
    table.need(api.init_device, "hdInitDevice");
    table.need(api.disable_device, "hdDisableDevice");
    table.need(api.make_current_device, "hdMakeCurrentDevice");
    table.need(api.begin_frame, "hdBeginFrame");
    table.need(api.end_frame, "hdEndFrame");
    table.need(api.get_error, "hdGetError");
    table.need(api.get_error_string, "hdGetErrorString");
    table.need(api.enable, "hdEnable");
    table.need(api.disable, "hdDisable");
    table.need(api.get_integers, "hdGetIntegerv");
    table.need(api.get_doubles, "hdGetDoublev");
    table.need(api.set_doubles, "hdSetDoublev");
    table.need(api.get_string, "hdGetString");
    table.need(api.set_rate, "hdSetSchedulerRate");
    table.need(api.start_scheduler, "hdStartScheduler");
    table.need(api.stop_scheduler, "hdStopScheduler");
    table.need(api.schedule, "hdScheduleAsynchronous");
    table.need(api.unschedule, "hdUnschedule");
    table.want(api.check_calibration, "hdCheckCalibration");
    table.want(api.update_calibration, "hdUpdateCalibration");
    if (Status status = table.finish(hd_advice); !status) return tl::unexpected(status.error());
    return api;
}

std::string hd_text(const char* text)
{
    return text != nullptr ? text : "";
}

/// The context of the callback.
struct HdTicks {
    explicit HdTicks(TickAccount ticks) : account(std::move(ticks)) {}

    TickAccount account;
    std::atomic<std::uint64_t> called{0};
    std::atomic<bool> ended{false};
};

unsigned int hd_tick(void* context)
{
    HdTicks& ticks = *static_cast<HdTicks*>(context);
    if (ticks.ended.load()) return callback_done;
    const Flow flow = ticks.account.tick();
    ticks.called.fetch_add(1);
    if (flow == Flow::proceed) return callback_continue;
    ticks.ended.store(true);
    return callback_done;
}

/// All devices share the driver's scheduler: the first starts it, the last stops it.
std::atomic<int> running_devices{0};

class HdDevice final : public Device {
public:
    HdDevice(SharedLibrary library, const HdApi& api, HdHandle handle, const HdOptions& options)
        : library_(std::move(library)), api_(api), handle_(handle)
    {
        describe_device(options);
    }
    ~HdDevice() override
    {
        const std::array<double, 3> nothing{};
        api_.make_current_device(handle_);
        api_.begin_frame(handle_);
        api_.set_doubles(current_force, nothing.data());
        api_.end_frame(handle_);
        api_.disable(force_output);
        api_.disable_device(handle_);
    }

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override;
    void write(const DeviceCommand& command) noexcept override;
    [[nodiscard]] std::string trouble() const override;
    [[nodiscard]] ServoStatistics run(const ServoOptions& options, ServoTick tick) override;

private:
    void describe_device(const HdOptions& options);
    void note(const HdError& error) noexcept;
    [[nodiscard]] std::string description(const HdError& error) const;

    SharedLibrary library_;
    HdApi api_;
    HdHandle handle_;
    DeviceInfo info_;
    DeviceReading reading_;
    HdError first_force_error_;
    HdError first_loss_;
    HdError first_refusal_; ///< of a call by write(), for another reason
    bool is_lost_ = false;  ///< to be said by the next reading
    HdError start_error_;   ///< of the scheduler's start: ticks leave it alone
    std::uint64_t force_errors_ = 0;
    double rate_ = usual_rate;  ///< Hz, of the session
    std::uint64_t resting_ = 0; ///< ticks in which forces rest after an error
    bool stalled_ = false;
    std::unique_ptr<HdTicks> ticks_; ///< kept, for a driver that hung may call once more
};

void HdDevice::describe_device(const HdOptions& options)
{
    const auto number = [&](HdEnum what, double otherwise) {
        double value = 0;
        api_.get_doubles(what, &value);
        (void)api_.get_error();
        return std::isfinite(value) && value > 0 ? value : otherwise;
    };
    info_.name = options.device.empty() ? "hd" : concat("hd:", options.device);
    info_.model =
        concat(hd_text(api_.get_string(vendor)), " ", hd_text(api_.get_string(model_type)));
    info_.serial = hd_text(api_.get_string(serial_number));
    info_.driver = concat(library_.path(), ", HD API ", hd_text(api_.get_string(api_version)),
                          ", driver ", hd_text(api_.get_string(driver_version)));
    const DeviceLimits touch = *find_device("touch");
    info_.limits.name = "hd";
    info_.limits.max_force = number(nominal_max_force, touch.max_force);
    // N/mm and N s/mm by the reference; a Touch's where the driver reports none.
    info_.limits.max_stiffness =
        number(nominal_max_stiffness, touch.max_stiffness * millimetre) / millimetre;
    info_.limits.max_damping =
        number(nominal_max_damping, touch.max_damping * millimetre) / millimetre;
    std::array<double, 6> box{};
    api_.get_doubles(usable_workspace, box.data());
    (void)api_.get_error();
    // The largest ball about the origin: full forces are guaranteed inside the box only.
    double radius = touch.workspace_radius / millimetre;
    const bool known =
        std::ranges::all_of(box, [](double x) { return std::isfinite(x); }) &&
        std::ranges::all_of(std::span(box).first<3>(), [](double x) { return x < 0; }) &&
        std::ranges::all_of(std::span(box).last<3>(), [](double x) { return x > 0; });
    if (known) {
        radius = std::abs(box[0]);
        for (const double x : box) radius = std::min(radius, std::abs(x));
    }
    info_.limits.workspace_radius = radius * millimetre;
    info_.buttons = 4;
    info_.rotates = true;
}

void HdDevice::note(const HdError& error) noexcept
{
    if (error.code >= first_force_error && error.code <= last_force_error) {
        // The driver has stopped the force: wait, then ramp it up.
        if (force_errors_++ == 0) first_force_error_ = error;
        resting_ = static_cast<std::uint64_t>(std::ceil(rest_seconds * rate_));
        return;
    }
    if (first_loss_.code == 0) first_loss_ = error;
    is_lost_ = true;
}

DeviceReading HdDevice::read() noexcept
{
    api_.make_current_device(handle_);
    api_.begin_frame(handle_);
    std::array<double, 16> transform{};
    std::array<double, 3> velocity{};
    int buttons = 0;
    api_.get_doubles(current_transform, transform.data());
    api_.get_doubles(current_velocity, velocity.data());
    api_.get_integers(current_buttons, &buttons);
    if (const HdError error = api_.get_error(); error.code != 0) note(error);
    if (std::exchange(is_lost_, false)) {
        reading_.state.condition = InputCondition::gone;
        return reading_;
    }
    // Column by column, as in OpenGL.
    RigidTransform& pose = reading_.state.pose;
    auto at = transform.begin();
    for (int column = 0; column < 3; ++column, ++at)
        for (int row = 0; row < 3; ++row) pose.rotation(row, column) = *at++;
    pose.translation = millimetre * Vec3(transform[12], transform[13], transform[14]);
    reading_.state.velocity = millimetre * Vec3(velocity[0], velocity[1], velocity[2]);
    reading_.state.buttons = static_cast<std::uint32_t>(buttons);
    reading_.state.condition = resting_ > 0 ? InputCondition::unsure : InputCondition::well;
    if (resting_ > 0 && --resting_ == 0) api_.enable(force_output);
    ++reading_.sample;
    return reading_;
}

void HdDevice::write(const DeviceCommand& command) noexcept
{
    const std::array<double, 3> force = {command.force.x(), command.force.y(), command.force.z()};
    api_.set_doubles(current_force, force.data());
    api_.end_frame(handle_);
    const HdError error = api_.get_error();
    if (error.code >= first_force_error && error.code <= last_device_error) {
        note(error);
    } else if (first_refusal_.code == 0) {
        first_refusal_ = error;
    }
}

std::string HdDevice::description(const HdError& error) const
{
    return concat(hd_text(api_.get_error_string(error.code)), " (error ", error.code, ", internal ",
                  error.internal_code, ")");
}

std::string HdDevice::trouble() const
{
    if (stalled_ && start_error_.code != 0)
        return concat("the driver's scheduler does not run: ", description(start_error_));
    if (stalled_)
        return "the driver's scheduler stopped calling: check that the device is plugged in";
    std::string said;
    const auto say = [&](const std::string& words) { said += (said.empty() ? "" : "; ") + words; };
    if (force_errors_ > 0) {
        say(concat("the driver stopped the force ", force_errors_,
                   " times: ", hd_text(api_.get_error_string(first_force_error_.code))));
    }
    if (first_loss_.code != 0) say("the driver lost the device: " + description(first_loss_));
    if (first_refusal_.code != 0) say("the driver refused a call: " + description(first_refusal_));
    return said;
}

ServoStatistics HdDevice::run(const ServoOptions& options, ServoTick tick)
{
    ticks_ = std::make_unique<HdTicks>(TickAccount(options, tick));
    HdTicks& ticks = *ticks_;
    api_.set_rate(static_cast<unsigned long>(std::llround(options.rate)));
    const HdError rate_error = api_.get_error();
    rate_ = rate_error.code == 0 ? options.rate : usual_rate;
    const HdCallbackHandle callback = api_.schedule(hd_tick, &ticks, highest_priority);
    if (running_devices.fetch_add(1) == 0) api_.start_scheduler();
    start_error_ = api_.get_error();
    // A driver that hangs must not hang the program: the session ends after a second without calls.
    constexpr auto pause = std::chrono::milliseconds(5);
    constexpr int patience = 200;
    std::uint64_t seen = 0;
    for (int silent = 0; !ticks.ended.load() && silent < patience; ++silent) {
        std::this_thread::sleep_for(pause);
        const std::uint64_t called = ticks.called.load();
        if (called != seen) silent = 0;
        seen = called;
    }
    stalled_ = !ticks.ended.exchange(true);
    if (running_devices.fetch_sub(1) == 1) api_.stop_scheduler();
    api_.unschedule(callback);
    (void)api_.get_error();
    ServoStatistics statistics = ticks.account.finish();
    statistics.note = "ticks are called by libHD's scheduler";
    if (rate_error.code != 0) {
        statistics.note += concat(", which keeps a rate of its own, for it refused ", options.rate,
                                  " Hz: ", description(rate_error));
    }
    return statistics;
}

/// Has the driver calibrate the device where it can. Error where a user has to.
Status calibrate(const HdApi& api)
{
    if (api.check_calibration == nullptr) return {};
    if (api.check_calibration() == calibration_needs_update && api.update_calibration != nullptr) {
        int styles = 0;
        api.get_integers(calibration_style, &styles);
        for (unsigned int style = 4; style >= 1; style /= 2) {
            if ((static_cast<unsigned int>(styles) & style) == 0) continue;
            api.update_calibration(style);
            break;
        }
    }
    (void)api.get_error();
    if (api.check_calibration() != calibration_needs_hands) return {};
    return fail(ErrorCode::limit_exceeded,
                "the device is not calibrated: put its stylus into the inkwell, or run the "
                "driver's diagnostics",
                "hd");
}

} // namespace

Result<std::unique_ptr<Device>> open_hd_device(const HdOptions& options)
{
    auto library = SharedLibrary::open({.what = "OpenHaptics' libHD.so",
                                        .names = {"libHD.so", "libHD.so.3.4", "/usr/lib/libHD.so",
                                                  "/usr/lib64/libHD.so", "/usr/local/lib/libHD.so"},
                                        .named = options.library,
                                        .advice = hd_advice});
    if (!library) return tl::unexpected(library.error());
    const auto api = load_hd_api(*library);
    if (!api) return tl::unexpected(api.error());
    const HdHandle handle =
        api->init_device(options.device.empty() ? nullptr : options.device.c_str());
    const HdError error = api->get_error();
    if (handle == invalid_handle || error.code != 0) {
        const std::string reported = hd_text(api->get_error_string(error.code));
        return fail(
            ErrorCode::invalid_argument,
            concat("cannot open ", options.device.empty() ? "the default device" : options.device,
                   ": ", reported, " (error ", error.code, ", internal ", error.internal_code,
                   "); check that it is plugged in and set up in the driver's configuration"),
            library->path());
    }
    auto device = std::make_unique<HdDevice>(std::move(*library), *api, handle, options);
    api->make_current_device(handle);
    if (Status status = calibrate(*api); !status) return tl::unexpected(status.error());
    api->enable(force_output);
    (void)api->get_error();
    return device;
}

} // namespace proxima
