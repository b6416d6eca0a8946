#include "haptics/device/udp_packets.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr PacketMagic state_magic = {'P', 'X', 'U', 'P'};
constexpr PacketMagic reply_magic = {'P', 'X', 'D', 'N'};

/// Calls field(x) for each field after the header, in the order of the bytes.
template <class Packet, class Field>
void visit_state(Packet& packet, const Field& field)
{
    field(packet.session);
    field(packet.sequence);
    field(packet.nanoseconds);
    field(packet.buttons);
    field(packet.flags);
    for (auto& x : packet.position) field(x);
    for (auto& x : packet.velocity) field(x);
    for (auto& x : packet.quaternion) field(x);
}

/// Like visit_state. The two numbers are those of `packet.command`, as they are sent.
template <class Packet, class Field>
void visit_reply(Packet& packet, std::uint32_t& condition, std::uint32_t& plane_count,
                 const Field& field)
{
    auto& command = packet.command;
    field(packet.session);
    field(packet.sequence);
    field(packet.nanoseconds);
    field(condition);
    field(plane_count);
    field(command.force);
    field(command.force_scale);
    field(packet.max_force);
    field(command.stiffness);
    field(command.damping);
    field(command.static_friction);
    field(command.dynamic_friction);
    field(command.anchor);
    for (auto& plane : command.planes) {
        field(plane.normal);
        field(plane.offset);
    }
    field(packet.hold_seconds);
    field(packet.fade_seconds);
    field(packet.recovery_seconds);
}

} // namespace

std::array<std::byte, state_packet_size> encode(const StatePacket& packet) noexcept
{
    std::array<std::byte, state_packet_size> bytes{};
    PacketWriter writer(bytes);
    writer.header(state_magic, udp_version);
    visit_state(packet, [&](const auto& x) { writer.put(x); });
    return bytes;
}

PacketFault decode(std::span<const std::byte> datagram, StatePacket& packet) noexcept
{
    if (datagram.size() != state_packet_size) return PacketFault::wrong_size;
    PacketReader reader(datagram);
    const PacketFault fault = reader.header(state_magic, udp_version);
    if (fault == PacketFault::none) visit_state(packet, [&](auto& x) { reader.get(x); });
    return fault;
}

std::array<std::byte, reply_packet_size> encode(const ReplyPacket& packet) noexcept
{
    std::array<std::byte, reply_packet_size> bytes{};
    auto condition = static_cast<std::uint32_t>(packet.command.condition);
    auto planes = static_cast<std::uint32_t>(packet.command.plane_count);
    PacketWriter writer(bytes);
    writer.header(reply_magic, udp_version);
    visit_reply(packet, condition, planes, [&](const auto& x) { writer.put(x); });
    return bytes;
}

PacketFault decode(std::span<const std::byte> datagram, ReplyPacket& packet) noexcept
{
    if (datagram.size() != reply_packet_size) return PacketFault::wrong_size;
    PacketReader reader(datagram);
    const PacketFault fault = reader.header(reply_magic, udp_version);
    if (fault != PacketFault::none) return fault;
    DeviceCommand& command = packet.command;
    std::uint32_t condition = 0;
    std::uint32_t planes = 0;
    visit_reply(packet, condition, planes, [&](auto& x) { reader.get(x); });
    command.condition = condition < input_conditions ? static_cast<InputCondition>(condition)
                                                     : InputCondition::unsure;
    command.plane_count = std::min<std::size_t>(planes, command.planes.size());
    return PacketFault::none;
}

DeviceState device_state(const StatePacket& packet) noexcept
{
    DeviceState state;
    state.pose.translation = Vec3(packet.position[0], packet.position[1], packet.position[2]);
    state.velocity = Vec3(packet.velocity[0], packet.velocity[1], packet.velocity[2]);
    state.buttons = packet.buttons;
    if ((packet.flags & StatePacket::leaving) != 0) state.condition = InputCondition::released;
    if ((packet.flags & StatePacket::rotates) != 0) {
        const auto& q = packet.quaternion;
        const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
        const double length = turn.norm();
        if (std::abs(length - 1) < 1e-3) state.pose.rotation = turn.normalized().toRotationMatrix();
    }
    return state;
}

} // namespace proxima
