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

} // namespace

std::array<std::byte, state_packet_size> encode(const StatePacket& packet) noexcept
{
    std::array<std::byte, state_packet_size> bytes{};
    Writer writer(bytes);
    writer.head(state_magic);
    writer.put(packet.session);
    writer.put(packet.sequence);
    writer.put(packet.nanoseconds);
    writer.put(packet.buttons);
    writer.put(packet.flags);
    for (const double x : packet.position) writer.put(x);
    for (const double x : packet.velocity) writer.put(x);
    for (const double x : packet.quaternion) writer.put(x);
    return bytes;
}

PacketFault decode(std::span<const std::byte> datagram, StatePacket& packet) noexcept
{
    Reader reader(datagram);
    const PacketFault fault = reader.head(state_magic, state_packet_size);
    if (fault != PacketFault::none) return fault;
    reader.get(packet.session);
    reader.get(packet.sequence);
    reader.get(packet.nanoseconds);
    reader.get(packet.buttons);
    reader.get(packet.flags);
    for (double& x : packet.position) reader.get(x);
    for (double& x : packet.velocity) reader.get(x);
    for (double& x : packet.quaternion) reader.get(x);
    return PacketFault::none;
}

std::array<std::byte, reply_packet_size> encode(const ReplyPacket& packet) noexcept
{
    std::array<std::byte, reply_packet_size> bytes{};
    const DeviceCommand& command = packet.command;
    Writer writer(bytes);
    writer.head(reply_magic);
    writer.put(packet.session);
    writer.put(packet.sequence);
    writer.put(packet.nanoseconds);
    writer.put(static_cast<std::uint32_t>(command.condition));
    writer.put(static_cast<std::uint32_t>(command.plane_count));
    writer.put(command.force);
    writer.put(command.trust);
    writer.put(packet.max_force);
    writer.put(command.stiffness);
    writer.put(command.damping);
    writer.put(command.static_friction);
    writer.put(command.dynamic_friction);
    writer.put(command.anchor);
    for (const DevicePlane& plane : command.planes) {
        writer.put(plane.normal);
        writer.put(plane.offset);
    }
    writer.put(packet.hold_seconds);
    writer.put(packet.fade_seconds);
    writer.put(packet.recovery_seconds);
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
    reader.get(packet.session);
    reader.get(packet.sequence);
    reader.get(packet.nanoseconds);
    reader.get(condition);
    reader.get(planes);
    command.condition = condition < input_conditions ? static_cast<InputCondition>(condition)
                                                     : InputCondition::unsure;
    command.plane_count = std::min<std::size_t>(planes, command.planes.size());
    reader.get(command.force);
    reader.get(command.trust);
    reader.get(packet.max_force);
    reader.get(command.stiffness);
    reader.get(command.damping);
    reader.get(command.static_friction);
    reader.get(command.dynamic_friction);
    reader.get(command.anchor);
    for (DevicePlane& plane : command.planes) {
        reader.get(plane.normal);
        reader.get(plane.offset);
    }
    reader.get(packet.hold_seconds);
    reader.get(packet.fade_seconds);
    reader.get(packet.recovery_seconds);
    return PacketFault::none;
}

DeviceState device_state(const StatePacket& packet) noexcept
{
    DeviceState state;
    state.pose.translation = Vec3(packet.position[0], packet.position[1], packet.position[2]);
    state.velocity = Vec3(packet.velocity[0], packet.velocity[1], packet.velocity[2]);
    state.buttons = packet.buttons;
    if ((packet.flags & StatePacket::leaving) != 0) state.condition = InputCondition::gone;
    if ((packet.flags & StatePacket::rotates) != 0) {
        const auto& q = packet.quaternion;
        const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
        const double length = turn.norm();
        if (std::abs(length - 1) < 1e-3) state.pose.rotation = turn.normalized().toRotationMatrix();
    }
    return state;
}

} // namespace proxima
