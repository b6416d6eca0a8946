// A device without hardware: a cursor that another thread moves, such as a mouse in a window.
//
//     CursorDevice cursor;
//     cursor.move_to(position, buttons);      // the window's thread, whenever the mouse moves
//     cursor.feedback()                       // the window's thread: force and position, to draw
//     device.read(), device.write(...)        // the servo thread, every tick
//
// A mouse reports a hundred positions a second and jumps between them; a hand does not. The tip
// follows the cursor like a critically damped spring, smooth in position and speed at every tick.
// Both directions use a Snapshot, so no thread waits for the other.
#pragma once

#include "haptics/loop/snapshot.h"
#include "proxima/device.h"

namespace proxima {

struct CursorOptions {
    DeviceLimits limits = *find_device("omni");
    double tick_seconds = 1e-3;
    double follow_seconds = 0.02; ///< until a quarter of a sudden step is left; 0: no smoothing
};

/// The last output of the servo thread.
struct CursorFeedback {
    Vec3 position = Vec3::Zero(); ///< of the tip, m of the device
    Vec3 force = Vec3::Zero();    ///< N
    std::uint64_t ticks = 0;      ///< so far
};

/// One thread moves it and reads the feedback, one other thread reads and writes.
class CursorDevice final : public Device {
public:
    /// At rest in the middle. \pre tick_seconds > 0, follow_seconds >= 0
    explicit CursorDevice(const CursorOptions& options = {});

    /// Moves the cursor, in metres of the device. Positions that are not finite are ignored. noexcept,
    /// wait-free.
    void move_to(const Vec3& position, std::uint32_t buttons = 0) noexcept;
    /// Puts cursor and tip at a position at once, such as after a change of the view.
    void place_at(const Vec3& position, std::uint32_t buttons = 0) noexcept;
    /// The newest output of the servo thread. noexcept, wait-free.
    [[nodiscard]] const CursorFeedback& feedback() noexcept;

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    [[nodiscard]] DeviceReading read() noexcept override;
    void write(const DeviceCommand& command) noexcept override;

private:
    struct Cursor {
        Vec3 position = Vec3::Zero();
        std::uint32_t buttons = 0;
        std::uint32_t placed = 0; ///< calls of place_at()
    };
    void send(const Vec3& position, std::uint32_t buttons) noexcept;

    DeviceInfo info_;
    double tick_seconds_;
    double pull_; ///< 1/s
    double kept_; ///< part of the distance that is left after a tick
    Snapshot<Cursor> cursor_;
    Snapshot<CursorFeedback> feedback_;
    std::uint32_t placed_ = 0; ///< of the moving thread
    DeviceReading reading_;    ///< of the servo thread, as the rest
    std::uint32_t seen_placed_ = 0;
    std::uint64_t writes_ = 0;
};

} // namespace proxima
