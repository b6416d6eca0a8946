// What a haptic device can take, and what it says every tick.
//
//     position, rotation, velocity, buttons   up, 1,000 times a second
//     force                                   down, within the limits of the device
//
//     device.run({.rate = 1000}, [&](std::uint64_t) noexcept {
//         const DeviceReading reading = device.read();
//         device.write({.force = renderer.tick(reading.state, 1e-3).force});
//         return Flow::proceed;
//     });
//
// Metres, newtons, seconds. Programs put a DeviceInput (device_input.h) between: it watches for
// what no hand does, turns the device's frame, and hands button events over.
#pragma once

#include "haptics/loop/servo_loop.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// Limits of a device, from its maker.
struct DeviceLimits {
    std::string_view name;
    double max_force = 3.3;          ///< N
    double max_stiffness = 400;      ///< N/m
    double max_damping = 4;          ///< N s/m
    double workspace_radius = 0.075; ///< m: of a ball that can be reached
};

/// The smaller of each limit, under the first one's name.
[[nodiscard]] DeviceLimits within(const DeviceLimits& limits, const DeviceLimits& other) noexcept;

/// The devices whose limits are known: touch, omni (the thesis's), desktop, falcon, omega, delta.
[[nodiscard]] std::span<const DeviceLimits> known_devices() noexcept;

/// By name.
[[nodiscard]] std::optional<DeviceLimits> find_device(std::string_view name) noexcept;

/// Whether a tick's state is a hand's, and if not, why the last good one stands for it. All but
/// `well` let the force fade.
enum class InputCondition : std::uint8_t {
    well,
    clutched, ///< the user moves the device without moving what it holds
    unsure,   ///< it said what no hand does (no number, a jump): until it is believed again
    frozen,   ///< it says the same, bit for bit, though it is pushed
    silent,   ///< nothing new came from it
    gone,     ///< it said that it is no longer there
    released  ///< the session ends
};
inline constexpr std::uint32_t input_conditions = 7;

/// What a device says: its tip and how it is held.
struct DeviceState {
    RigidTransform pose;          ///< of the tip; metres
    Vec3 velocity = Vec3::Zero(); ///< of the tip, m/s, as the device says or from differences
    std::uint32_t buttons = 0;    ///< a bit each
    InputCondition condition = InputCondition::well;
};

/// What a device says in a tick, and how new it is.
struct DeviceReading {
    DeviceState state;        ///< of condition well, unsure or gone; any numbers, also none
    std::uint64_t sample = 0; ///< of how many samples this is the last: the same as in the tick
                              ///< before where nothing new came
};

/// A plane of the contact: the tip is held where normal . x >= offset. In the device's metres.
struct HeldPlane {
    Vec3 normal = Vec3::UnitZ();
    double offset = 0;
};

/// What a device gets in a tick: a force, and for those with a servo loop of their own what it
/// comes from.
struct DeviceCommand {
    Vec3 force = Vec3::Zero(); ///< N: finite, within the limits, ramps included
    InputCondition condition = InputCondition::well; ///< of what the device said
    double trust = 1;           ///< 0 to 1: the ramps, by which forces of `planes` are scaled
    double stiffness = 0;       ///< N/m
    double damping = 0;         ///< N s/m
    double static_friction = 0; ///< of the moment: less while it slides
    double dynamic_friction = 0;
    Vec3 held = Vec3::Zero(); ///< what the spring pulls to, m; no meaning without planes
    std::array<HeldPlane, 3> planes = {};
    std::size_t plane_count = 0;
};

/// Whether a device that nobody touches may say the same for long.
enum class Stillness : bool { usual, suspicious };

/// What there is to know of a device.
struct DeviceInfo {
    std::string name;    ///< as asked for: "hand", "cursor", "udp:4711", "hd", "dhd"
    std::string model;   ///< of its maker, "" where unknown
    std::string serial;  ///< "" where unknown
    std::string driver;  ///< library and version, "" for none
    DeviceLimits limits; ///< of which `name` refers to static text
    int buttons = 0;
    bool pushes = true;   ///< somebody feels its force: sessions end with a fading one
    bool rotates = false; ///< says how it is held, not only where
    Stillness stillness = Stillness::suspicious;
    /// How long nothing new may come before the device counts as silent, s.
    double patience = 0.02;
};

/// A device, real or not. One thread calls run(), and it the tick, which calls read() once and then
/// write() once; these two are noexcept, allocate nothing, take no lock of ours and wait for nobody
/// but a driver. Ends, with the force at zero, in its destructor.
class Device {
public:
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    virtual ~Device() = default;

    [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
    [[nodiscard]] virtual DeviceReading read() noexcept = 0;
    virtual void write(const DeviceCommand& command) noexcept = 0;

    /// Calls tick(number) at the device's rate until it says stop or all are done: on this thread
    /// and by our clock, or where a driver has a scheduler, on its thread and by its clock.
    template <class Tick>
    [[nodiscard]] ServoStatistics run(const ServoOptions& options, Tick&& tick)
    {
        return run_ticks(options, detail::plain_tick<std::remove_reference_t<Tick>>,
                         const_cast<void*>(static_cast<const void*>(&tick)));
    }

    /// What went wrong since it was opened, in words; "" for nothing. Not while run() runs.
    [[nodiscard]] virtual std::string trouble() const { return {}; }

protected:
    [[nodiscard]] virtual ServoStatistics run_ticks(const ServoOptions& options,
                                                    detail::ServoTick tick, void* context)
    {
        return detail::run_servo_loop(options, tick, context);
    }
};

} // namespace proxima
