#include "haptics/channel/engine_link.h"

#include "base/check.h"
#include "base/text.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/scene/material_change.h"
#include "haptics/scene/scene_input.h"
#include "proxima/haptic_renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unistd.h>
#include <utility>

namespace proxima {

namespace {

constexpr int packets_per_tick = 64;

/// An engine that begins anew is heard this long after its last packet, another one so much later. For
/// as long an engine gets packets without sending any.
constexpr double engine_patience = 0.02;
constexpr double engine_forgotten_after = 1;

/// s: of an engine whose packets do not tell yet.
constexpr double usual_period = 0.02;
constexpr double longest_measured_period = 0.1;

/// Bounds of what packets say.
constexpr double most_period = 1;            // s
constexpr double most_material_seconds = 10; // s
constexpr std::uint32_t most_reply_every = 1000;
constexpr double most_strength = 1e9;       // as recordings have it
constexpr double farthest_position = 1e100; // as recordings have it

constexpr double coast_periods = 2;

std::int64_t monotonic_now() noexcept
{
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

bool is_within(double value, double most) noexcept
{
    return value >= 0 && value <= most;
}

bool is_within(const Vec3& v, double most) noexcept
{
    return (v.array().abs() <= most).all();
}

/// The rotation of a quaternion; false where it is not of length 1, up to the rounding of floats.
bool to_rotation(const std::array<double, 4>& q, Mat3& rotation) noexcept
{
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (!(std::abs(turn.norm() - 1) <= nearly_rigid_tolerance)) return false;
    rotation = turn.normalized().toRotationMatrix();
    return true;
}

} // namespace

double Lateness::add(std::uint64_t stamp, std::int64_t now) noexcept
{
    constexpr std::int64_t second = 1'000'000'000;
    // In doubles, for stamps may be any numbers.
    const double difference = static_cast<double>(now) - static_cast<double>(stamp);
    if (is_empty_ || now - begin_ >= 2 * second) {
        quickest_ = before_ = difference;
        begin_ = now;
        is_empty_ = false;
    } else if (now - begin_ >= second) {
        before_ = quickest_;
        quickest_ = difference;
        begin_ = now;
    }
    quickest_ = std::min(quickest_, difference);
    return 1e-9 * (difference - std::min(quickest_, before_));
}

EngineLink::EngineLink(std::unique_ptr<EngineTransport> transport)
    : transport_(std::move(transport)), order_(engine_patience, engine_forgotten_after),
      session_(static_cast<std::uint64_t>(monotonic_now()) ^ static_cast<std::uint64_t>(getpid())
                                                                 << 40U)
{}

bool EngineLink::is_accepted(const UdpAddress& from, std::int64_t now) noexcept
{
    switch (order_.judge(packet_.session, packet_.sequence, from, now)) {
    case PacketVerdict::foreign:
        ++report_.foreign;
        return false;
    case PacketVerdict::duplicated:
        ++report_.duplicated;
        return false;
    case PacketVerdict::reordered:
        ++report_.reordered;
        return false;
    case PacketVerdict::leapt:
        ++report_.leapt;
        return false;
    case PacketVerdict::well:
        break;
    }
    return true;
}

/// The time from an object's last pose to the one in this packet: as the packet says, or by the time
/// stamps, shared with packets that were lost in between.
double EngineLink::update_period(PoseTimes& times) const noexcept
{
    const double passed =
        1e-9 * (static_cast<double>(packet_.nanoseconds) - static_cast<double>(times.stamp));
    if (packet_.period > 0) {
        times.period = packet_.period;
    } else if (times.period == 0) {
        times.period = usual_period;
    } else if (passed > 0) {
        const auto lost = static_cast<double>(report_.lost - times.lost);
        times.period = std::min(passed / (1 + lost), longest_measured_period);
    }
    times.stamp = packet_.nanoseconds;
    times.lost = report_.lost;
    return times.period;
}

void EngineLink::take(std::span<const std::byte> packet, const UdpAddress& from,
                      std::int64_t now) noexcept
{
    ++report_.received;
    const PacketFault fault = decode(packet, packet_);
    if (fault == PacketFault::wrong_version) {
        ++report_.other_versions;
        other_version_ = static_cast<std::uint16_t>(std::to_integer<unsigned>(packet[4]) |
                                                    std::to_integer<unsigned>(packet[5]) << 8U);
        return;
    }
    const bool in_range = is_within(packet_.period, most_period) &&
                          is_within(packet_.material_seconds, most_material_seconds) &&
                          packet_.reply_every <= most_reply_every;
    if (fault != PacketFault::none || !in_range) {
        ++report_.malformed;
        return;
    }
    if (!is_accepted(from, now)) return;
    if (order_.is_first()) {
        lateness_.restart();
        poses_ = {};
    }
    report_.lost += order_.accept(packet_.sequence, now);
    report_.sessions = order_.sessions();
    ++report_.accepted;
    stamp_ = packet_.nanoseconds;
    reply_every_ = packet_.reply_every;
    unanswered_ = true;
    left_ = (packet_.flags & ScenePacket::leaving) != 0;
    if (left_) order_.leave();
    const double late = lateness_.add(packet_.nanoseconds, now);
    for (const PacketObject& object : std::span(packet_.objects).first(packet_.count))
        merge(object, late);
}

/// Checks an object of a packet, but for what only the scene knows, and adds it to the tick's.
void EngineLink::merge(const PacketObject& object, double late) noexcept
{
    constexpr std::uint32_t known =
        PacketObject::has_pose | PacketObject::has_velocity | PacketObject::has_material;
    const bool has_pose = (object.flags & PacketObject::has_pose) != 0;
    const bool has_velocity = (object.flags & PacketObject::has_velocity) != 0;
    const bool has_material = (object.flags & PacketObject::has_material) != 0;
    bool right = object.object < max_scene_objects && (object.flags & ~known) == 0 &&
                 (has_pose || !has_velocity);
    ObjectMotion motion;
    if (right && has_pose) {
        right = to_rotation(object.quaternion, motion.pose.rotation) &&
                is_within(object.position, farthest_position);
        motion.pose.translation = object.position;
    }
    if (right && has_velocity) {
        right = is_within(object.velocity, farthest_position) && is_within(object.spin, most_spin);
        motion.velocity = object.velocity;
        motion.spin = object.spin;
    }
    if (right && has_material) {
        const SurfaceMaterial& m = object.material;
        right =
            is_valid(m) && std::max({m.stiffness, m.damping, m.static_friction}) <= most_strength;
    }
    if (!right) {
        ++report_.refused_objects;
        return;
    }
    SceneMessage& message = merged_[object.object];
    if (has_pose) {
        const double period = update_period(poses_[object.object]);
        motion.seconds = period - std::min(late, period / 2);
        motion.coast_seconds = has_velocity ? coast_periods * period : 0;
        message.has_motion = true;
        message.motion = motion;
    }
    if (has_material) {
        message.has_material = true;
        message.material = object.material;
        message.material_seconds = packet_.material_seconds;
    }
}

std::span<const SceneMessage> EngineLink::receive(TouchScene& scene, std::uint64_t tick,
                                                  double seconds, std::int64_t now) noexcept
{
    for (int i = 0; i < packets_per_tick; ++i) {
        const auto received = transport_->receive(buffer_);
        if (!received) break;
        take(std::span(buffer_).first(std::min(received->size, buffer_.size())), received->from,
             now);
    }
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < max_scene_objects; ++i) {
        SceneMessage& message = merged_[i];
        if (!message.has_motion && !message.has_material) continue;
        message.tick = tick;
        message.object = ObjectId{i};
        message.motion.seconds = std::max(message.motion.seconds, seconds);
        // An object at the edge of the scene stops there.
        if (!is_applicable(message, scene)) message.motion.coast_seconds = 0;
        if (!is_applicable(message, scene)) {
            ++report_.refused_objects;
            message.has_motion = false; // a material counts without it
        }
        if ((message.has_motion || message.has_material) && is_applicable(message, scene)) {
            const Status applied = apply(message, scene);
            PROXIMA_CHECK(applied.has_value());
            report_.motions += message.has_motion ? 1U : 0U;
            report_.materials += message.has_material ? 1U : 0U;
            messages_[count++] = message;
        }
        message.has_motion = message.has_material = false;
    }
    return std::span(messages_).first(count);
}

/// Whether the engine is to get a packet of this tick.
bool EngineLink::is_due(std::int64_t now) noexcept
{
    if (transport_->keeps_packets()) return true;
    const double silent = 1e-9 * static_cast<double>(now - order_.last_heard());
    if (!order_.serves() || left_ || silent > engine_forgotten_after) return false;
    return reply_every_ == 0 ? std::exchange(unanswered_, false) : ticks_ % reply_every_ == 0;
}

TouchPacket EngineLink::touch_packet(const HapticRenderer& renderer, const DeviceState& state,
                                     std::int64_t now) noexcept
{
    const RenderTick& tick = renderer.last();
    const SurfaceRenderer& parts = parts_of(renderer);
    const WorkspaceMap& map = renderer.map();
    TouchPacket packet;
    packet.session = session_;
    packet.sequence = ticks_;
    packet.nanoseconds = static_cast<std::uint64_t>(now);
    if (report_.accepted > 0) {
        packet.engine_session = order_.session();
        packet.engine_sequence = order_.sequence();
        packet.engine_nanoseconds = stamp_;
    }
    packet.accepted = report_.accepted;
    packet.lost = report_.lost;
    packet.refused = report_.received - report_.accepted;
    packet.refused_objects = report_.refused_objects;
    packet.unsent = report_.unsent;
    packet.condition = static_cast<std::uint32_t>(tick.condition);
    const std::uint64_t limited = parts.guard().clamped();
    const std::uint64_t slewed = parts.guard().slewed();
    packet.flags = (tick.is_placed ? touch_placed : 0U) | (tick.squeezed ? touch_squeezed : 0U) |
                   (tick.fault == InputFault::jumped ? touch_jumped : 0U) |
                   (limited != limited_ ? touch_limited : 0U) |
                   (slewed != slewed_ ? touch_slewed : 0U);
    limited_ = limited;
    slewed_ = slewed;
    packet.hold = static_cast<std::uint32_t>(tick.hold);
    packet.contact_count = static_cast<std::uint32_t>(tick.contact_count);
    packet.buttons = state.buttons;
    packet.units_per_metre = map.units_per_metre;
    packet.center = map.center;
    packet.device = map.to_model(tick.position);
    if (state.pose.rotation.allFinite()) {
        const Eigen::Quaterniond turn(state.pose.rotation);
        packet.rotation = {turn.w(), turn.x(), turn.y(), turn.z()};
    }
    packet.proxy = tick.proxy;
    packet.anchor = tick.anchor;
    packet.force = tick.force;
    packet.normal = tick.normal;
    packet.depth = tick.depth;
    packet.surface_velocity = tick.surface_velocity;
    packet.force_scale = parts.guard().ramp();
    packet.softness = parts.passivity().softness();
    packet.added_damping = parts.passivity().added_damping();
    for (std::size_t i = 0; i < tick.contact_count; ++i) {
        const ContactPoint& contact = tick.contacts[i];
        packet.contacts[i] = {to_index(object_of(contact.triangle)),
                              to_index(triangle_of(contact.triangle)), contact.position,
                              contact.normal, contact.pressure};
    }
    return packet;
}

void EngineLink::send(const HapticRenderer& renderer, const DeviceState& state,
                      std::int64_t now) noexcept
{
    ++ticks_;
    if (!is_due(now)) return;
    std::array<std::byte, touch_packet_size> bytes;
    encode(touch_packet(renderer, state, now), bytes);
    const bool sent = transport_->send(bytes, order_.peer());
    report_.sent += sent ? 1U : 0U;
    report_.unsent += sent ? 0U : 1U;
}

std::string EngineLink::trouble() const
{
    if (transport_->is_cut_off()) {
        return concat("another program shortened the memory of ", name(),
                      ": the engine was no longer heard");
    }
    if (report_.other_versions > 0) {
        return concat(report_.other_versions, " packets at ", name(), " have version ",
                      other_version_, " of the protocol, and this program has ", engine_version,
                      ": use an engine's side and a Proxima that fit each other");
    }
    if (report_.accepted > 0) return {};
    if (report_.received > 0) {
        return concat("none of ", report_.received, " packets at ", name(),
                      " is a scene packet: see docs/engine_channel.md for the format");
    }
    return concat("no packet arrived at ", name(),
                  ": start the engine's program and make it send there");
}

EngineChannel::EngineChannel(std::unique_ptr<EngineLink> link) noexcept : link_(std::move(link)) {}
EngineChannel::EngineChannel(EngineChannel&& other) noexcept = default;
EngineChannel& EngineChannel::operator=(EngineChannel&& other) noexcept = default;
EngineChannel::~EngineChannel() = default;

void EngineChannel::receive(TouchScene& scene, double seconds) noexcept
{
    (void)link_->receive(scene, 0, seconds, monotonic_now());
}

void EngineChannel::send(const HapticRenderer& renderer, const DeviceState& state) noexcept
{
    link_->send(renderer, state, monotonic_now());
}

const EngineReport& EngineChannel::report() const noexcept
{
    return link_->report();
}

std::string EngineChannel::trouble() const
{
    return link_->trouble();
}

Result<EngineChannel> open_engine_channel(std::string_view name)
{
    auto transport = open_engine_transport(name);
    if (!transport) return tl::unexpected(transport.error());
    return EngineChannel(std::make_unique<EngineLink>(std::move(*transport)));
}

} // namespace proxima
