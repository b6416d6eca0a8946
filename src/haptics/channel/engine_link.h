// The implementation of EngineChannel (touch_scene.h): which packets count, what they mean for the
// scene, and what the engine gets of a tick.
//
//     packet    whole, of our version, of one engine at a time, newer than the last (packet_sequence.h)
//     object    there, with a rigid pose within the scene, a valid material: else it is left out
//     motion    in place one period after the packet: its own, or the time since the object's last pose
//
// Of several packets within a tick the newest pose of each object counts, and the newest material. A
// packet that is late by less than half a period is made up for: its objects arrive when they would
// have arrived. One that never comes leaves its objects where they arrived, or coasting for two
// periods where the engine gave velocities.
#pragma once

#include "haptics/channel/engine_packets.h"
#include "haptics/channel/engine_transport.h"
#include "haptics/channel/scene_message.h"
#include "haptics/device/packet_sequence.h"
#include "proxima/device.h"
#include "proxima/touch_scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace proxima {

/// How much longer a packet was on its way than the quickest of the last one to two seconds, by time
/// stamps of a clock that is not ours. noexcept.
class Lateness {
public:
    /// Forgets all packets.
    void restart() noexcept { *this = {}; }
    /// Seconds, at least 0, of a packet that came at `now`. ns
    double add(std::uint64_t stamp, std::int64_t now) noexcept;

private:
    double quickest_ = 0; ///< ns, arrival less stamp, of this second
    double before_ = 0;   ///< and of the one before
    std::int64_t begin_ = 0;
    bool is_empty_ = true;
};

/// The servo thread's. Times are nanoseconds of CLOCK_MONOTONIC, or of a test's own clock.
class PROXIMA_HIDDEN EngineLink {
public:
    explicit EngineLink(std::unique_ptr<EngineTransport> transport);

    /// Takes what came, applies it to the scene, and returns it: at most a message for each object,
    /// by object. They are valid until the next call. noexcept, no allocation.
    std::span<const SceneMessage> receive(TouchScene& scene, std::uint64_t tick, double seconds,
                                          std::int64_t now) noexcept;

    void send(const HapticRenderer& renderer, const DeviceState& state, std::int64_t now) noexcept;

    /// Handles a packet that came, as receive() does those of the transport. noexcept, any bytes.
    void take(std::span<const std::byte> packet, const UdpAddress& from, std::int64_t now) noexcept;

    [[nodiscard]] const EngineReport& report() const noexcept { return report_; }
    [[nodiscard]] std::string trouble() const;
    [[nodiscard]] std::string name() const { return transport_->name(); }

private:
    /// When the poses of an object came.
    struct PoseTimes {
        std::uint64_t stamp = 0; ///< of the last one's packet
        std::uint64_t lost = 0;  ///< packets that were lost until then
        double period = 0;       ///< s from pose to pose; 0 before the session's first
    };

    [[nodiscard]] bool is_accepted(const UdpAddress& from, std::int64_t now) noexcept;
    [[nodiscard]] double update_period(PoseTimes& times) const noexcept;
    void merge(const PacketObject& object, double late) noexcept;
    [[nodiscard]] bool is_due(std::int64_t now) noexcept;
    [[nodiscard]] TouchPacket touch_packet(const HapticRenderer& renderer, const DeviceState& state,
                                           std::int64_t now) noexcept;

    std::unique_ptr<EngineTransport> transport_;
    PacketSequence order_;
    Lateness lateness_;
    EngineReport report_;
    std::uint64_t session_ = 0; ///< ours
    std::uint64_t ticks_ = 0;
    std::uint64_t stamp_ = 0;         ///< of the packet accepted last
    std::uint32_t reply_every_ = 1;   ///< as it says
    std::uint16_t other_version_ = 0; ///< of a packet that was refused for it
    bool unanswered_ = false;
    bool left_ = false;         ///< the engine ended its session
    std::uint64_t limited_ = 0; ///< ticks until now in which the force was cut off
    std::uint64_t slewed_ = 0;

    ScenePacket packet_;                               ///< being taken
    std::array<PoseTimes, max_scene_objects> poses_{}; ///< of this session, by object
    std::array<std::byte, most_scene_packet_size + 8> buffer_{};
    std::array<SceneMessage, max_scene_objects> merged_{}; ///< of this tick, by object
    std::array<SceneMessage, max_scene_objects> messages_{};
};

} // namespace proxima
