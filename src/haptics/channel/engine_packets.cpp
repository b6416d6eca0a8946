#include "haptics/channel/engine_packets.h"

#include <algorithm>

namespace proxima {

namespace {

constexpr PacketMagic scene_magic = {'P', 'X', 'S', 'C'};
constexpr PacketMagic touch_magic = {'P', 'X', 'T', 'O'};

/// Calls field(x) for each field after the packet's header, in the order of the bytes.
template <class Packet, class Field>
void visit_scene(Packet& packet, std::uint32_t& count, std::uint32_t& reserved, const Field& field)
{
    field(packet.session);
    field(packet.sequence);
    field(packet.nanoseconds);
    field(count);
    field(packet.flags);
    field(packet.period);
    field(packet.material_seconds);
    field(packet.reply_every);
    field(reserved);
}

template <class Object, class Field>
void visit_object(Object& object, const Field& field)
{
    field(object.object);
    field(object.flags);
    field(object.position);
    for (auto& x : object.quaternion) field(x);
    field(object.velocity);
    field(object.spin);
    field(object.material.stiffness);
    field(object.material.damping);
    field(object.material.static_friction);
    field(object.material.dynamic_friction);
}

template <class Packet, class Field>
void visit_touch(Packet& packet, std::uint32_t& reserved, const Field& field)
{
    field(packet.session);
    field(packet.sequence);
    field(packet.nanoseconds);
    field(packet.engine_session);
    field(packet.engine_sequence);
    field(packet.engine_nanoseconds);
    field(packet.accepted);
    field(packet.lost);
    field(packet.refused);
    field(packet.refused_objects);
    field(packet.unsent);
    field(packet.condition);
    field(packet.flags);
    field(packet.hold);
    field(packet.contact_count);
    field(packet.buttons);
    field(reserved);
    field(packet.units_per_metre);
    field(packet.center);
    field(packet.device);
    for (auto& x : packet.rotation) field(x);
    field(packet.proxy);
    field(packet.anchor);
    field(packet.force);
    field(packet.torque);
    field(packet.normal);
    field(packet.depth);
    field(packet.surface_velocity);
    field(packet.force_scale);
    field(packet.softness);
    field(packet.added_damping);
    for (auto& contact : packet.contacts) {
        field(contact.object);
        field(contact.triangle);
        field(contact.position);
        field(contact.normal);
        field(contact.pressure);
    }
}

} // namespace

PacketFault decode(std::span<const std::byte> bytes, ScenePacket& packet) noexcept
{
    PacketReader reader(bytes);
    const PacketFault fault = reader.header(scene_magic, engine_version);
    if (fault != PacketFault::none) return fault;
    if (bytes.size() < scene_header_size) return PacketFault::wrong_size;
    const auto get = [&](auto& x) { reader.get(x); };
    std::uint32_t count = 0;
    std::uint32_t reserved = 0;
    visit_scene(packet, count, reserved, get);
    packet.count = 0;
    if (count > max_scene_objects || bytes.size() != scene_header_size + count * scene_object_size)
        return PacketFault::wrong_size;
    packet.count = count;
    for (PacketObject& object : std::span(packet.objects).first(count)) visit_object(object, get);
    return PacketFault::none;
}

PacketFault decode(std::span<const std::byte> bytes, TouchPacket& packet) noexcept
{
    PacketReader reader(bytes);
    const PacketFault fault = reader.header(touch_magic, engine_version);
    if (fault != PacketFault::none) return fault;
    if (bytes.size() != touch_packet_size) return PacketFault::wrong_size;
    std::uint32_t reserved = 0;
    visit_touch(packet, reserved, [&](auto& x) { reader.get(x); });
    packet.contact_count = std::min<std::uint32_t>(
        packet.contact_count, static_cast<std::uint32_t>(packet.contacts.size()));
    return PacketFault::none;
}

std::size_t encode(const ScenePacket& packet,
                   std::span<std::byte, most_scene_packet_size> bytes) noexcept
{
    const std::size_t size = scene_header_size + packet.count * scene_object_size;
    PacketWriter writer(std::span<std::byte>(bytes).first(size));
    writer.header(scene_magic, engine_version);
    const auto put = [&](const auto& x) { writer.put(x); };
    auto count = static_cast<std::uint32_t>(packet.count);
    std::uint32_t reserved = 0;
    visit_scene(packet, count, reserved, put);
    for (const PacketObject& object : std::span(packet.objects).first(packet.count))
        visit_object(object, put);
    return size;
}

void encode(const TouchPacket& packet, std::span<std::byte, touch_packet_size> bytes) noexcept
{
    PacketWriter writer(bytes);
    writer.header(touch_magic, engine_version);
    std::uint32_t reserved = 0;
    visit_touch(packet, reserved, [&](const auto& x) { writer.put(x); });
}

} // namespace proxima
