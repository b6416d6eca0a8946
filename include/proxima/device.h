// A haptic device, the loop that serves it a thousand times a second, and the guard of its input.
//
//     device.read() ─▶ DeviceInput ─▶ renderer.tick() ─▶ DeviceInput ─▶ device.write()
//                           └─▶ report, button events
//
//     auto device = open_device("udp:4711");                          // or a class of your own
//     auto input = make_device_input((*device)->info());
//     auto seen = (*device)->run({.rate = 1000, .ticks = 5000}, [&](std::uint64_t) {
//         renderer.tick(input->accept((*device)->read()), 1e-3);      // haptic_renderer.h
//         (*device)->write(input->command(renderer));
//         return Flow::proceed;
//     });
//
// Lengths are metres, forces newtons, times seconds. A device of your own derives from Device:
// info(), read() and write() are all that it needs.
#pragma once

#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace PROXIMA_EXPORT proxima {

class HapticRenderer;
class InputGuard;
class ToolRenderer;

/// Limits of a device, as its maker states them.
struct DeviceLimits {
    std::string_view name = {};      ///< refers to static text
    double max_force = 3.3;          ///< N
    double max_stiffness = 400;      ///< N/m
    double max_damping = 4;          ///< N s/m
    double workspace_radius = 0.075; ///< m, of a ball that the tip can reach
    double max_torque = 0;           ///< N m; 0 = a device without torques
};

/// The smaller of each limit, under the first one's name.
[[nodiscard]] DeviceLimits within(const DeviceLimits& limits, const DeviceLimits& other) noexcept;

/// The devices whose limits are known: touch, omni (the thesis's), desktop, falcon, omega, delta.
[[nodiscard]] std::span<const DeviceLimits> known_devices() noexcept;

/// The limits of a known device; nothing where the name is unknown.
[[nodiscard]] std::optional<DeviceLimits> find_device(std::string_view name) noexcept;

/// Whether the state of a tick is the device's own, and if not, why the last good state replaces
/// it. The force fades under all conditions but `well`.
enum class InputCondition : std::uint8_t {
    well,
    clutched, ///< the user moves the device, and its position in the model stays
    unsure,   ///< a sample that no hand can produce (not a number, a jump)
    frozen,   ///< the same bits again and again from a device for which that is impossible
    silent,   ///< no new sample came
    gone,     ///< the driver reported that the device is no longer there
    released  ///< the program or the device ends the session
};
/// How many conditions there are.
inline constexpr std::uint32_t input_conditions = 7;

/// Pose, velocity and buttons of a device.
struct DeviceState {
    RigidTransform pose = {};     ///< of the tip; metres
    Vec3 velocity = Vec3::Zero(); ///< of the tip, m/s
    std::uint32_t buttons = 0;    ///< a bit each
    InputCondition condition = InputCondition::well;
};

/// What a device reports in a tick, and how new it is.
struct DeviceReading {
    DeviceState state = {};   ///< condition well, unsure, gone or released; numbers may be anything
    std::uint64_t sample = 0; ///< counts samples from 1; unchanged where no new one came
};

/// A plane of the contact: the tip may be where normal . x >= offset. In the device's metres.
struct DevicePlane {
    Vec3 normal = Vec3::UnitZ(); ///< of length 1
    double offset = 0;           ///< m
};

/// What a device gets in a tick: a force, and for devices with a servo loop of their own what the
/// force was made from. A program that only has a force sets that alone.
struct DeviceCommand {
    Vec3 force = Vec3::Zero();  ///< N: finite, within the limits, ramps included
    Vec3 torque = Vec3::Zero(); ///< N m, likewise; zero for devices without torques
    InputCondition condition = InputCondition::well; ///< of the reading that it answers
    double force_scale = 1;     ///< 0 to 1: the ramps; multiplies forces made from `planes`
    double stiffness = 0;       ///< N/m; this and the next three: of the materials that are touched
    double damping = 0;         ///< N s/m
    double static_friction = 0; ///< smaller while the tip slides
    double dynamic_friction = 0;
    Vec3 anchor = Vec3::Zero(); ///< what the spring pulls to, m; no meaning without planes
    std::array<DevicePlane, 3> planes = {};
    std::size_t plane_count = 0;
};

/// What it means when a device reports the same bits for long although a force pushes it. Friction
/// and encoder steps keep a real device on one position for as long as the hand holds still.
enum class Stillness : std::uint8_t {
    usual,      ///< nothing
    suspicious, ///< it is counted, and the force stays
    impossible ///< the device is frozen, and the force fades: for drivers whose samples never repeat
};

/// Name, limits and abilities of a device.
struct DeviceInfo {
    std::string name = {};   ///< as it was opened: "udp:4711", "hd", "dhd"
    std::string model = {};  ///< of its maker, "" where unknown
    std::string serial = {}; ///< "" where unknown
    std::string driver = {}; ///< library and version, "" for none
    DeviceLimits limits = {};
    int buttons = 0;
    bool pushes = true;   ///< somebody feels its force, so sessions end with a fading force
    bool rotates = false; ///< reports its rotation, not only its position
    Stillness stillness = Stillness::suspicious;
    double patience = 0.02; ///< s without a new sample after which the device counts as silent
};

/// Counts durations, from 0 to 2^63 nanoseconds, in bins that are at most three per cent wide.
/// 17 KB; one thread; noexcept, no allocation.
class LatencyHistogram {
public:
    /// Counts one duration; a negative one as 0. O(1).
    void add(std::int64_t nanoseconds) noexcept;
    /// Adds all that another histogram has counted.
    void add(const LatencyHistogram& other) noexcept;

    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    [[nodiscard]] std::uint64_t max() const noexcept { return max_; } ///< ns, exact

    /// How many are below a power of two of nanoseconds, exactly.
    [[nodiscard]] std::uint64_t count_below(std::uint64_t power_of_two) const noexcept;

    /// The duration that at least this part of all do not exceed, ns, rounded up to the end of its
    /// bin; 0 where nothing was counted. \pre 0 <= part <= 1
    [[nodiscard]] std::uint64_t quantile(double part) const noexcept;

private:
    static constexpr unsigned fine_bits = 5; // 32 bins to a power of two

    std::array<std::uint64_t, std::size_t{65} << fine_bits> bins_{};
    std::uint64_t count_ = 0;
    std::uint64_t max_ = 0;
};

/// How a loop keeps its rate.
enum class Pace : std::uint8_t {
    real_time,   ///< at its rate, with real-time priority and locked memory where these are granted
    best_effort, ///< at its rate, as any other thread
    unpaced      ///< tick after tick: for tests and measurements
};

struct ServoOptions {
    double rate = 1000;                      ///< ticks per second
    std::optional<std::uint64_t> ticks = {}; ///< the loop ends after so many; with nothing, when
                                             ///< a tick returns Flow::stop
    Pace pace = Pace::best_effort;
};

/// What a loop did, and how well it kept its rate.
struct ServoStatistics {
    std::uint64_t ticks = 0;
    std::uint64_t missed = 0;      ///< deadlines
    std::uint64_t overslept = 0;   ///< of these: woken up after the deadline, before any work
    std::uint64_t skipped = 0;     ///< planned ticks that were left out
    double seconds = 0;            ///< from the first tick to the last
    LatencyHistogram late;         ///< waking up after the planned time, ns
    LatencyHistogram work;         ///< inside ticks, ns
    std::uint64_t page_faults = 0; ///< of this thread, from the first tick to the last
    bool real_time_priority = false;
    bool locked_memory = false;
    std::string note; ///< what was requested and not granted, and what would help; else empty
};

/// One tick of a loop, by number from 0. It must not throw.
using ServoTick = FunctionRef<Flow(std::uint64_t number)>;

/// Calls tick(number) for every tick on this thread, until it returns stop or all are done. Sleeps
/// to absolute times: tick i is planned at begin + i / rate. A tick that ends after the next one
/// was planned has missed its deadline; planned ticks whose time passed meanwhile are left out.
/// Between the first and the last tick nothing is allocated.
/// \pre rate is positive and finite
[[nodiscard]] ServoStatistics run_servo_loop(const ServoOptions& options, ServoTick tick);

/// A device, real or not. One thread calls run(), and its tick calls read() once and then write()
/// once. These two are noexcept, allocate nothing, take no lock and wait for nobody but a driver.
/// The destructor of a driver sets the force to zero.
class Device {
public:
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    virtual ~Device() = default;

    [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
    [[nodiscard]] virtual DeviceReading read() noexcept = 0;
    virtual void write(const DeviceCommand& command) noexcept = 0;

    /// Calls tick(number) at the device's rate until it returns stop or all are done: on this
    /// thread by run_servo_loop(), or, where a driver has a scheduler, on the driver's thread.
    [[nodiscard]] virtual ServoStatistics run(const ServoOptions& options, ServoTick tick)
    {
        return run_servo_loop(options, tick);
    }

    /// What went wrong since the device was opened, in words; "" for nothing. Not during run().
    [[nodiscard]] virtual std::string trouble() const { return {}; }
};

struct OpenDeviceOptions {
    std::string library = {};                   ///< file of libHD.so or libdhd.so; "" to search
    DeviceLimits limits = *find_device("omni"); ///< of udp; drivers know those of their devices
};

/// Opens a device by name (docs/devices.md):
///     hd, hd:NAME                   3D Systems, by OpenHaptics' libHD.so
///     dhd, dhd:INDEX                Force Dimension and Falcon, by libdhd.so
///     udp:PORT, udp:ADDRESS:PORT    a device in another program
/// Errors: invalid_argument (another name, no such device, what the driver says), file_not_found
/// (no library: what was tried and what to install), unsupported_format (functions that the library
/// lacks), limit_exceeded (the device has to be calibrated first).
[[nodiscard]] Result<std::unique_ptr<Device>> open_device(std::string_view name,
                                                          const OpenDeviceOptions& options = {});

/// Whether open_device() takes the name. The device itself may be missing.
[[nodiscard]] bool is_device_name(std::string_view name);

struct InputOptions {
    double tick_seconds = 1e-3;              ///< > 0
    double max_jump = 0.05;                  ///< m between two samples: 50 m/s at 1 kHz
    double max_distance = 10;                ///< m from the device's origin, along each axis
    double settle_seconds = 0.1;             ///< of samples that agree, before a jump is accepted
    std::optional<Stillness> stillness = {}; ///< instead of DeviceInfo::stillness
    double frozen_seconds = 0.5;             ///< of the same bits, before a pushed device is judged
    double frozen_force = 0.05;              ///< N: a smaller force does not push the device
    Mat3 rotation = Mat3::Identity();        ///< from the device's axes to those of the model
    std::uint32_t clutch_buttons = 0; ///< bits: while one of them is pressed, the clutch is open
};

/// Faults of a session's input, counted.
struct InputReport {
    std::uint64_t samples = 0;      ///< new ones
    std::uint64_t not_finite = 0;   ///< samples with a position out of range or not a number
    std::uint64_t jumps = 0;        ///< farther than a hand moves between two samples
    std::uint64_t velocities = 0;   ///< samples whose velocity contradicts the positions
    std::uint64_t suspicions = 0;   ///< times that a pushed device reported the same bits for long
    std::uint64_t freezes = 0;      ///< of these, where that is impossible and the force faded
    std::uint64_t silences = 0;     ///< times that nothing came for longer than its patience
    std::uint64_t losses = 0;       ///< times that the driver reported the device gone
    std::uint64_t faulty_ticks = 0; ///< ticks that were unsure, frozen, silent or gone
    std::uint64_t clutched_ticks = 0; ///< ticks with an open clutch
    double longest_fault = 0;         ///< s, from the first faulty tick to the last
    std::uint64_t recoveries = 0;     ///< times that the whole force came back after a fault
    double longest_recovery = 0;      ///< s, from the first good tick to the whole force
};

/// Press or release of a button.
struct ButtonEvent {
    std::uint64_t tick = 0; ///< in which the device reported it
    int button = 0;         ///< from 0
    bool pressed = false;   ///< or released

    friend bool operator==(const ButtonEvent&, const ButtonEvent&) = default;
};

/// The guard between a device and a renderer: accepts only input that a hand can produce, turns the
/// device's axes, and lets the user reposition the device with a clutch button.
///
/// The last good position replaces input that is not plausible, with a condition that lets the force
/// fade (ForceOptions::loss_seconds). Once the device is well the force comes back as slowly.
///     not a number, or metres away          unsure    until there is a good sample
///     a jump that no hand makes             unsure    until settle_seconds of samples agree
///     the same bits while pushed            frozen    only where Stillness::impossible
///     nothing new                           silent    after DeviceInfo::patience
///     the driver reports it                 gone
///     the device ends the session           released
///     a clutch button                       clutched  while it is pressed
/// A velocity that contradicts the positions is replaced by one of their differences, and nothing
/// fades. New samples that repeat the last one are not silence: the force stays.
///
/// One per device, for the servo thread alone but for next_button_event(). noexcept, no allocation,
/// no lock, O(1).
class DeviceInput {
public:
    DeviceInput(DeviceInput&& other) noexcept;
    DeviceInput& operator=(DeviceInput&& other) noexcept;
    ~DeviceInput();

    /// The state for the renderer's tick. Before the first good sample its position is not a number,
    /// and the renderer touches nothing.
    const DeviceState& accept(const DeviceReading& reading) noexcept;

    /// The command for the device after the renderer's tick, in the device's axes.
    [[nodiscard]] DeviceCommand command(const HapticRenderer& renderer) noexcept;

    /// What the device is to give for a tool: force and torque, without planes.
    [[nodiscard]] DeviceCommand command(const ToolRenderer& renderer) noexcept;

    /// From the next tick on the force fades for good: the session ends.
    void release() noexcept;

    /// The next press or release, in order; nothing where there is none. One other thread may call
    /// it; events beyond 256 that were not taken are dropped.
    [[nodiscard]] std::optional<ButtonEvent> next_button_event() noexcept;

    [[nodiscard]] const InputReport& report() const noexcept;
    /// What accept() returned last.
    [[nodiscard]] const DeviceState& state() const noexcept;

private:
    friend Result<DeviceInput> make_device_input(const DeviceInfo& info,
                                                 const InputOptions& options);
    explicit DeviceInput(std::unique_ptr<InputGuard> guard) noexcept;

    std::unique_ptr<InputGuard> guard_; ///< not null but after a move
};

/// Error invalid_argument, naming the option: a number that is negative or not finite, a tick of 0 s,
/// a matrix that is no rotation.
[[nodiscard]] Result<DeviceInput> make_device_input(const DeviceInfo& info,
                                                    const InputOptions& options = {});

} // namespace proxima
