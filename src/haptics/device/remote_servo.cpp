#include "haptics/device/remote_servo.h"

#include "base/check.h"
#include "geometry/length.h"
#include "haptics/force/contact_force.h"
#include "haptics/proxy/contact_planes.h"
#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// No device has larger numbers, in SI units; results computed from smaller ones are finite.
constexpr double largest = 1e6;

bool is_sound(const Vec3& v) noexcept
{
    return v.allFinite() && v.cwiseAbs().maxCoeff() <= largest;
}

bool is_sound(const ReplyPacket& reply) noexcept
{
    const DeviceCommand& c = reply.command;
    bool sound = is_sound(c.force) && is_sound(c.anchor) && c.force_scale <= 1;
    for (const double x :
         {c.force_scale, c.stiffness, c.damping, c.static_friction, c.dynamic_friction,
          reply.max_force, reply.hold_seconds, reply.fade_seconds, reply.recovery_seconds})
        sound = sound && x >= 0 && x <= largest;
    for (const DevicePlane& plane : std::span(c.planes).first(c.plane_count)) {
        sound = sound && std::abs(plane.offset) <= largest && is_sound(plane.normal) &&
                std::abs(plane.normal.norm() - 1) < 1e-6;
    }
    return sound;
}

Vec3 limited(const Vec3& v, double most) noexcept
{
    const double length = length_of(v);
    return length <= most ? v : Vec3(v * (most / length * (1 - 0x1p-40)));
}

/// Spring and damper between the tip and the nearest position that the planes allow.
Vec3 contact_force(const DeviceCommand& c, const Vec3& position, const Vec3& velocity) noexcept
{
    std::array<ContactPlane, 3> planes;
    for (std::size_t i = 0; i < c.plane_count; ++i)
        planes[i] = {c.planes[i].normal, c.planes[i].normal.dot(position) - c.planes[i].offset};
    constexpr double tolerance = 1e-9; // m
    const PlaneSolution solution =
        nearest_allowed(std::span(planes).first(c.plane_count), tolerance);
    const double depth = solution.shift.norm();
    if (!(depth > 0)) return Vec3::Zero();
    // Friction moves the anchor towards the renderer's.
    const Vec3 normal = solution.shift / depth;
    Vec3 aside = c.anchor - (position + solution.shift);
    aside -= normal * normal.dot(aside);
    const double distance = aside.norm();
    const bool sticks = distance <= c.static_friction * depth;
    const double trail = c.dynamic_friction * depth;
    if (!sticks && distance > trail) aside *= trail / distance;
    const ForceOptions options{.stiffness = c.stiffness, .damping = c.damping};
    return spring_force(options, {true, solution.shift + aside, normal}, velocity);
}

} // namespace

RemoteServo::RemoteServo(double max_force) noexcept : max_force_(max_force)
{
    PROXIMA_CHECK_GT(max_force, 0);
}

void RemoteServo::take(const ReplyPacket& reply, double now) noexcept
{
    const bool old =
        received_ && reply.session == reply_.session && reply.sequence < reply_.sequence;
    if (old || !is_sound(reply)) {
        ++refused_;
        return;
    }
    reply_ = reply;
    received_ = true;
    switched_ = true;
    received_at_ = now;
}

Vec3 RemoteServo::force(const Vec3& position, const Vec3& velocity, double now) noexcept
{
    const double tick = std::clamp(now - last_now_, 0.0, 0.01);
    last_now_ = now;
    const bool sound = is_sound(position) && is_sound(velocity);
    const bool good = received_ && sound && now - received_at_ <= reply_.hold_seconds;
    const double step = reply_.fade_seconds > 0 ? tick / reply_.fade_seconds : 1;
    fade_factor_ = std::clamp(fade_factor_ + (good ? step : -step), 0.0, 1.0);
    const double most = received_ ? std::min(max_force_, reply_.max_force) : 0;
    if (!sound) {
        fade_factor_ = 0;
        return Vec3::Zero();
    }
    const Vec3 wanted = contact_force(reply_.command, position, velocity);
    const auto left = [&] {
        const double whole = reply_.recovery_seconds;
        return whole > 0 ? std::clamp(1 - (now - switched_at_) / whole, 0.0, 1.0) : 0.0;
    };
    if (switched_) {
        // The difference of the forces by the last planes and the new ones fades.
        difference_ = left() * difference_ + contact_force(used_, position, velocity) - wanted;
        switched_at_ = now;
        used_ = reply_.command;
        switched_ = false;
    }
    return limited(reply_.command.force_scale * fade_factor_ * (wanted + left() * difference_),
                   most);
}

} // namespace proxima
