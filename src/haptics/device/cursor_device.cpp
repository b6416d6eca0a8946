#include "haptics/device/cursor_device.h"

#include "base/check.h"

#include <cmath>

namespace proxima {

CursorDevice::CursorDevice(const CursorOptions& options)
    : tick_seconds_(options.tick_seconds),
      // A step d leaves d (1 + t w) exp(-t w): a quarter is left at t w = 2.69.
      pull_(options.follow_seconds > 0 ? 2.69 / options.follow_seconds : 0),
      kept_(std::exp(-pull_ * options.tick_seconds))
{
    PROXIMA_CHECK_GT(options.tick_seconds, 0);
    PROXIMA_CHECK_GE(options.follow_seconds, 0);
    info_.name = "cursor";
    info_.limits = options.limits;
    info_.buttons = 3;
    info_.stillness = Stillness::usual;
}

void CursorDevice::send(const Vec3& position, std::uint32_t buttons) noexcept
{
    cursor_.writing() = {position, buttons, placed_};
    cursor_.publish();
}

void CursorDevice::move_to(const Vec3& position, std::uint32_t buttons) noexcept
{
    if (position.allFinite()) send(position, buttons);
}

void CursorDevice::place_at(const Vec3& position, std::uint32_t buttons) noexcept
{
    if (!position.allFinite()) return;
    ++placed_;
    send(position, buttons);
}

const CursorFeedback& CursorDevice::feedback() noexcept
{
    feedback_.update();
    return feedback_.reading();
}

DeviceReading CursorDevice::read() noexcept
{
    cursor_.update();
    const Cursor& cursor = cursor_.reading();
    Vec3& position = reading_.state.pose.translation;
    Vec3& velocity = reading_.state.velocity;
    if (cursor.placed != seen_placed_) {
        seen_placed_ = cursor.placed;
        position = cursor.position;
        velocity = Vec3::Zero();
    } else if (pull_ > 0) {
        // The exact motion of the tip over a tick with the cursor at rest.
        const Vec3 offset = position - cursor.position;
        const Vec3 rate = velocity + pull_ * offset;
        position = cursor.position + kept_ * (offset + tick_seconds_ * rate);
        velocity = kept_ * (velocity - (pull_ * tick_seconds_) * rate);
    } else {
        velocity = (cursor.position - position) / tick_seconds_;
        position = cursor.position;
    }
    reading_.state.buttons = cursor.buttons;
    ++reading_.sample;
    return reading_;
}

void CursorDevice::write(const DeviceCommand& command) noexcept
{
    feedback_.writing() = {reading_.state.pose.translation, command.force, ++writes_};
    feedback_.publish();
}

} // namespace proxima
