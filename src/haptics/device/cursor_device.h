// A device for those who have none: a cursor that another thread moves, such as a mouse's in a
// window.
//
//     CursorDevice cursor;
//     cursor.move_to(position, buttons);      // the window's thread, whenever the mouse moves
//     cursor.felt()                           // the window's thread: force and place, to be drawn
//     device.read(), device.write(...)        // the servo thread, every tick
//
// A mouse says a hundred places a second and jumps between them; a hand does not. The tip follows
// the cursor like a critically damped spring without a mass that pushes back: smooth in place and
// speed at every tick. Both ways by Snapshot: no thread waits for the other.
#pragma once

#include "haptics/loop/snapshot.h"
#include "proxima/device.h"

namespace proxima {

struct CursorOptions {
    DeviceLimits limits = *find_device("omni");
    double tick_seconds = 1e-3;
    double follow_seconds = 0.02; ///< until about a quarter of a sudden step is left over; 0: none
};

/// What the servo thread last wrote.
struct CursorFeeling {
    Vec3 position = Vec3::Zero(); ///< of the tip, m of the device
    Vec3 force = Vec3::Zero();    ///< N
    std::uint64_t ticks = 0;      ///< so far
};

/// One thread moves it and asks what was felt, one other thread reads and writes.
class CursorDevice final : public Device {
public:
    /// At rest in the middle. \pre tick_seconds > 0, follow_seconds >= 0
    explicit CursorDevice(const CursorOptions& options = {});

    /// Where the cursor is, metres of the device. The newest counts; one that is not finite is left
    /// out. noexcept, wait-free.
    void move_to(const Vec3& position, std::uint32_t buttons = 0) noexcept;
    /// Puts cursor and tip there at once: after a jump that is no motion, such as another view.
    void place_at(const Vec3& position, std::uint32_t buttons = 0) noexcept;
    /// The newest that the servo thread wrote. noexcept, wait-free.
    [[nodiscard]] const CursorFeeling& felt() noexcept;

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override;
    void write(const DeviceCommand& command) noexcept override;

private:
    struct Cursor {
        Vec3 position = Vec3::Zero();
        std::uint32_t buttons = 0;
        std::uint32_t placed = 0; ///< how often it was put somewhere
    };
    void say(const Vec3& position, std::uint32_t buttons) noexcept;

    DeviceInfo info_;
    double tick_seconds_;
    double pull_; ///< 1/s
    double kept_; ///< of the way, in a tick
    Snapshot<Cursor> cursor_;
    Snapshot<CursorFeeling> feeling_;
    std::uint32_t placed_ = 0; ///< the mover's
    DeviceReading reading_;    ///< the servo thread's from here
    std::uint32_t seen_placed_ = 0;
    std::uint64_t writes_ = 0;
};

} // namespace proxima
