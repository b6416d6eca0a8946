// A haptic device, and the loop that serves it a thousand times a second.
//
//     position, rotation, velocity, buttons   up, 1,000 times a second
//     force                                   down, within the limits of the device
//
//     const ServoStatistics seen = device.run({.rate = 1000, .ticks = 5000}, [&](std::uint64_t) {
//         const DeviceReading reading = device.read();
//         device.write({.force = renderer.tick(reading.state, 1e-3).force});
//         return Flow::proceed;
//     });
//
// Lengths are metres, forces newtons, times seconds. A device of your own derives from Device:
// info(), read() and write() are all that it needs.
#pragma once

#include "proxima/function_ref.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// Limits of a device, from its maker.
struct DeviceLimits {
    std::string_view name = {};      ///< refers to static text
    double max_force = 3.3;          ///< N
    double max_stiffness = 400;      ///< N/m
    double max_damping = 4;          ///< N s/m
    double workspace_radius = 0.075; ///< m: of a ball that can be reached
};

/// The smaller of each limit, under the first one's name.
[[nodiscard]] DeviceLimits within(const DeviceLimits& limits, const DeviceLimits& other) noexcept;

/// The devices whose limits are known: touch, omni (the thesis's), desktop, falcon, omega, delta.
[[nodiscard]] std::span<const DeviceLimits> known_devices() noexcept;

/// The limits of a known device; nothing where the name is unknown.
[[nodiscard]] std::optional<DeviceLimits> find_device(std::string_view name) noexcept;

/// Whether the state of a tick is the device's own, and if not, why the last good one stands for
/// it. The force fades under all conditions but `well`.
enum class InputCondition : std::uint8_t {
    well,
    clutched, ///< the user moves the device without moving what it holds
    unsure,   ///< a sample that no hand can produce (not a number, a jump)
    frozen,   ///< the same bits again and again, though the device is pushed
    silent,   ///< no new sample came
    gone,     ///< the driver reported that the device is no longer there
    released  ///< the session ends
};
/// How many conditions there are.
inline constexpr std::uint32_t input_conditions = 7;

/// Where the tip of a device is and how it is held.
struct DeviceState {
    RigidTransform pose = {};     ///< of the tip; metres
    Vec3 velocity = Vec3::Zero(); ///< of the tip, m/s
    std::uint32_t buttons = 0;    ///< a bit each
    InputCondition condition = InputCondition::well;
};

/// What a device reports in a tick, and how new it is.
struct DeviceReading {
    DeviceState state = {};   ///< of condition well, unsure or gone; numbers may be anything
    std::uint64_t sample = 0; ///< counts samples: the same as in the tick before if none came
};

/// A plane of the contact: the tip is held where normal . x >= offset. In the device's metres.
struct HeldPlane {
    Vec3 normal = Vec3::UnitZ(); ///< of length 1
    double offset = 0;           ///< m
};

/// What a device gets in a tick: a force, and for devices with a servo loop of their own what the
/// force was made from. A program that only has a force sets that alone.
struct DeviceCommand {
    Vec3 force = Vec3::Zero(); ///< N: finite, within the limits, ramps included
    InputCondition condition = InputCondition::well; ///< of the reading that it answers
    double trust = 1;           ///< 0 to 1: the ramps, by which forces of `planes` are scaled
    double stiffness = 0;       ///< N/m
    double damping = 0;         ///< N s/m
    double static_friction = 0; ///< less while the tip slides
    double dynamic_friction = 0;
    Vec3 anchor = Vec3::Zero(); ///< what the spring pulls to, m; no meaning without planes
    std::array<HeldPlane, 3> planes = {};
    std::size_t plane_count = 0;
};

/// Whether a device may report the same bits for long while nobody touches it.
enum class Stillness : bool { usual, suspicious };

/// Name, limits and abilities of a device.
struct DeviceInfo {
    std::string name = {};    ///< as asked for: "hand", "cursor", "udp:4711", "hd", "dhd"
    std::string model = {};   ///< of its maker, "" where unknown
    std::string serial = {};  ///< "" where unknown
    std::string driver = {};  ///< library and version, "" for none
    DeviceLimits limits = {}; ///< of which `name` refers to static text
    int buttons = 0;
    bool pushes = true;   ///< somebody feels its force: sessions end with a fading one
    bool rotates = false; ///< reports its rotation, not only its position
    Stillness stillness = Stillness::suspicious;
    double patience = 0.02; ///< s without a new sample, until the device counts as silent
};

/// Counts of durations, from 0 to 2^63 nanoseconds, in bins that are at most three per cent wide.
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
    std::optional<std::uint64_t> ticks = {}; ///< the loop ends after so many; nothing: when a
                                             ///< tick answers Flow::stop
    Pace pace = Pace::best_effort;
};

/// What a loop did, and how well it kept its rate.
struct ServoStatistics {
    std::uint64_t ticks = 0;
    std::uint64_t missed = 0;      ///< deadlines
    std::uint64_t overslept = 0;   ///< of these: woken up after the deadline, before any work
    std::uint64_t skipped = 0;     ///< planned times that were left out
    double seconds = 0;            ///< from the first tick to the last
    LatencyHistogram late;         ///< waking up after the planned time, ns
    LatencyHistogram work;         ///< inside of ticks, ns
    std::uint64_t page_faults = 0; ///< of this thread, from the first tick to the last
    bool real_time_priority = false;
    bool locked_memory = false;
    std::string note; ///< what was asked for and not granted, and what would help; else empty
};

/// One tick of a loop, by number from 0. It must not throw.
using ServoTick = FunctionRef<Flow(std::uint64_t number)>;

/// Calls tick(number) for every tick on this thread, until it answers stop or all are done. Sleeps
/// to absolute times: tick i is planned at begin + i / rate. A tick that ends after the next one
/// was planned has missed its deadline; planned times that passed meanwhile are left out, not
/// caught up with. Between the first and the last tick nothing is allocated.
/// \pre rate is positive and finite
[[nodiscard]] ServoStatistics run_servo_loop(const ServoOptions& options, ServoTick tick);

/// A device, real or not. One thread calls run(), and its tick calls read() once and then write()
/// once. These two are noexcept, allocate nothing, take no lock and wait for nobody but a driver.
/// The destructor sets the force to zero.
class Device {
public:
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    virtual ~Device() = default;

    [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
    [[nodiscard]] virtual DeviceReading read() noexcept = 0;
    virtual void write(const DeviceCommand& command) noexcept = 0;

    /// Calls tick(number) at the device's rate until it answers stop or all are done: on this
    /// thread by run_servo_loop(), or, where a driver has a scheduler, on the driver's thread.
    [[nodiscard]] virtual ServoStatistics run(const ServoOptions& options, ServoTick tick)
    {
        return run_servo_loop(options, tick);
    }

    /// What went wrong since the device was opened, in words; "" for nothing. Not during run().
    [[nodiscard]] virtual std::string trouble() const { return {}; }
};

} // namespace proxima
