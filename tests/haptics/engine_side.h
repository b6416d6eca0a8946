// The engine's side of a channel, for tests: packets, and both ways to bring them to Proxima.
#pragma once

#include "haptics/channel/engine_link.h"
#include "haptics/channel/engine_packets.h"
#include "haptics/channel/engine_transport.h"
#include "haptics/channel/shared_segment.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fcntl.h>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <sys/mman.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace proxima::testing {

inline constexpr std::uint64_t engine_session = 4711;

/// A packet that an engine with a clock of its own, 1 s behind ours, sends at a time, ns.
[[nodiscard]] inline ScenePacket scene_packet(std::uint64_t sequence, std::int64_t now)
{
    ScenePacket packet;
    packet.session = engine_session;
    packet.sequence = sequence;
    packet.nanoseconds = static_cast<std::uint64_t>(now - 1'000'000'000);
    return packet;
}

inline PacketObject& add_pose(ScenePacket& packet, std::uint32_t object, const Vec3& position,
                              const Mat3& rotation = Mat3::Identity())
{
    PacketObject& added = packet.objects[packet.count++];
    added = {};
    added.object = object;
    added.flags = PacketObject::has_pose;
    added.position = position;
    const Eigen::Quaterniond turn(rotation);
    added.quaternion = {turn.w(), turn.x(), turn.y(), turn.z()};
    return added;
}

[[nodiscard]] inline std::vector<std::byte> bytes_of(const ScenePacket& packet)
{
    std::vector<std::byte> bytes(most_scene_packet_size);
    bytes.resize(encode(packet, std::span<std::byte, most_scene_packet_size>(bytes)));
    return bytes;
}

/// A name of shared memory that no other test has.
[[nodiscard]] inline std::string segment_name(const std::string& test)
{
    return "test-" + std::to_string(getpid()) + "-" + test;
}

/// A segment, mapped as an engine maps it.
class MappedSegment {
public:
    explicit MappedSegment(const std::string& name)
    {
        const std::string path = "/proxima-" + name;
        const int file = shm_open(path.c_str(), O_RDWR, 0);
        EXPECT_GE(file, 0);
        void* const memory =
            mmap(nullptr, segment_size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        EXPECT_NE(memory, MAP_FAILED);
        close(file);
        bytes_ = {static_cast<std::byte*>(memory), segment_size};
    }
    MappedSegment(const MappedSegment&) = delete;
    MappedSegment& operator=(const MappedSegment&) = delete;
    ~MappedSegment() { munmap(bytes_.data(), bytes_.size()); }

    [[nodiscard]] std::span<std::byte> bytes() const { return bytes_; }

private:
    std::span<std::byte> bytes_;
};

/// Sends packets to a channel and hears what it says.
class EngineSide {
public:
    virtual ~EngineSide() = default;
    virtual void send(std::span<const std::byte> packet) = 0;
    [[nodiscard]] virtual std::vector<TouchPacket> hear() = 0;
};

class UdpEngineSide final : public EngineSide {
public:
    explicit UdpEngineSide(const EngineLink& link)
        : to_(*parse_udp_address(link.name().substr(4))), socket_(*UdpSocket::listen({}))
    {}
    void send(std::span<const std::byte> packet) override
    {
        EXPECT_TRUE(socket_.send(packet, to_));
    }
    [[nodiscard]] std::vector<TouchPacket> hear() override
    {
        std::vector<TouchPacket> heard;
        std::vector<std::byte> buffer(2048);
        while (const auto got = socket_.receive(buffer)) {
            heard.emplace_back();
            EXPECT_EQ(decode(std::span(buffer).first(got->size), heard.back()), PacketFault::none);
        }
        return heard;
    }

private:
    UdpAddress to_;
    UdpSocket socket_;
};

class SharedEngineSide final : public EngineSide {
public:
    explicit SharedEngineSide(const EngineLink& link) : segment_(link.name().substr(4)) {}
    void send(std::span<const std::byte> packet) override
    {
        write_packet(segment_.bytes(), scene_ring, written_++, packet);
    }
    [[nodiscard]] std::vector<TouchPacket> hear() override
    {
        std::vector<TouchPacket> heard;
        std::vector<std::byte> buffer(touch_packet_size);
        for (; read_ < packets_written(segment_.bytes(), touch_ring); ++read_) {
            const std::size_t size = read_packet(segment_.bytes(), touch_ring, read_, buffer);
            heard.emplace_back();
            EXPECT_EQ(size, touch_packet_size);
            EXPECT_EQ(decode(buffer, heard.back()), PacketFault::none);
        }
        return heard;
    }

private:
    MappedSegment segment_;
    std::uint64_t written_ = 0;
    std::uint64_t read_ = 0;
};

/// Waits until all packets arrived that were sent, so that a session does not depend on the system.
class PatientTransport final : public EngineTransport {
public:
    explicit PatientTransport(std::unique_ptr<EngineTransport> transport)
        : transport_(std::move(transport))
    {}
    /// One more packet was sent.
    void expect() { ++expected_; }

    [[nodiscard]] std::string name() const override { return transport_->name(); }
    [[nodiscard]] std::optional<UdpSocket::Received>
    receive(std::span<std::byte> buffer) noexcept override
    {
        auto received = transport_->receive(buffer);
        for (int wait = 0; !received && expected_ > 0 && wait < 10000; ++wait) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            received = transport_->receive(buffer);
        }
        if (received) --expected_;
        return received;
    }
    bool send(std::span<const std::byte, touch_packet_size> packet,
              const UdpAddress& to) noexcept override
    {
        return transport_->send(packet, to);
    }
    [[nodiscard]] bool is_cut_off() const noexcept override { return transport_->is_cut_off(); }
    [[nodiscard]] bool keeps_packets() const noexcept override
    {
        return transport_->keeps_packets();
    }

private:
    std::unique_ptr<EngineTransport> transport_;
    int expected_ = 0;
};

} // namespace proxima::testing
