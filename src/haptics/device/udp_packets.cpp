#include "haptics/device/udp_packets.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace proxima {

namespace {

constexpr std::array<char, 4> state_magic = {'P', 'X', 'U', 'P'};
constexpr std::array<char, 4> reply_magic = {'P', 'X', 'D', 'N'};

/// Writes numbers one after another, the lowest byte first.
class Writer {
public:
    explicit Writer(std::span<std::byte> bytes) noexcept : bytes_(bytes) {}

    template <class Number>
    void put(Number number) noexcept
    {
        for (std::size_t i = 0; i < sizeof(Number); ++i)
            bytes_[at_++] = static_cast<std::byte>(number >> (8 * i) & 255U);
    }
    void put(double number) noexcept { put(std::bit_cast<std::uint64_t>(number)); }
    void put(const Vec3& v) noexcept
    {
        for (const double x : v) put(x);
    }
    void head(const std::array<char, 4>& magic) noexcept
    {
        for (const char letter : magic) put(static_cast<std::uint8_t>(letter));
        put(udp_version);
        put(static_cast<std::uint16_t>(bytes_.size()));
    }

private:
    std::span<std::byte> bytes_;
    std::size_t at_ = 0;
};

/// Reads numbers that a Writer wrote. \pre the bytes suffice
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

    template <class Number>
    void get(Number& number) noexcept
    {
        number = 0;
        for (std::size_t i = 0; i < sizeof(Number); ++i)
            number |= static_cast<Number>(static_cast<Number>(bytes_[at_++]) << (8 * i));
    }
    void get(double& number) noexcept
    {
        std::uint64_t bits = 0;
        get(bits);
        number = std::bit_cast<double>(bits);
    }
    void get(Vec3& v) noexcept
    {
        for (double& x : v) get(x);
    }
    [[nodiscard]] PacketFault head(const std::array<char, 4>& magic, std::size_t size) noexcept
    {
        if (bytes_.size() != size) return PacketFault::wrong_size;
        bool same = true;
        for (const char letter : magic) {
            std::uint8_t byte = 0;
            get(byte);
            same = same && byte == static_cast<std::uint8_t>(letter);
        }
        if (!same) return PacketFault::wrong_magic;
        std::uint16_t version = 0;
        std::uint16_t reported = 0;
        get(version);
        get(reported);
        if (version != udp_version) return PacketFault::wrong_version;
        return reported == size ? PacketFault::none : PacketFault::wrong_size;
    }

private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

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
    Writer writer(bytes);
    writer.head(state_magic);
    visit_state(packet, [&](const auto& x) { writer.put(x); });
    return bytes;
}

PacketFault decode(std::span<const std::byte> datagram, StatePacket& packet) noexcept
{
    Reader reader(datagram);
    const PacketFault fault = reader.head(state_magic, state_packet_size);
    if (fault == PacketFault::none) visit_state(packet, [&](auto& x) { reader.get(x); });
    return fault;
}

std::array<std::byte, reply_packet_size> encode(const ReplyPacket& packet) noexcept
{
    std::array<std::byte, reply_packet_size> bytes{};
    auto condition = static_cast<std::uint32_t>(packet.command.condition);
    auto planes = static_cast<std::uint32_t>(packet.command.plane_count);
    Writer writer(bytes);
    writer.head(reply_magic);
    visit_reply(packet, condition, planes, [&](const auto& x) { writer.put(x); });
    return bytes;
}

PacketFault decode(std::span<const std::byte> datagram, ReplyPacket& packet) noexcept
{
    Reader reader(datagram);
    const PacketFault fault = reader.head(reply_magic, reply_packet_size);
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
