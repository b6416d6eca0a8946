// A channel to an engine in another program, which owns the world: Unity, Unreal, Godot, ROS. It sends
// where objects are and what they are made of; Proxima keeps device, meshes and servo loop, and gives
// back what is touched, in every tick.
//
//     engine  ──poses, velocities, materials──▶  channel  ──▶ TouchScene       60 to 100 times a second
//     engine  ◀──proxy, anchor, force, contacts──  channel  ◀── HapticRenderer  1,000 times a second
//
//     auto channel = open_engine_channel("udp:4712");                 // or "shm:NAME"
//     auto renderer = make_haptic_renderer(scene, map, limits);
//     each tick:  channel->receive(scene, 1e-3);
//                 const DeviceState& state = input->accept(device.read());
//                 renderer->tick(state, 1e-3);
//                 device.write(input->command(*renderer));
//                 channel->send(*renderer, state);
//
// docs/engine_channel.md describes the packets byte by byte; examples/engine_client.py and
// examples/engine_client.c are the engine's side.
#pragma once

#include "proxima/haptic_renderer.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace proxima {

class EngineLink;

/// Counts of a channel's packets.
struct EngineReport {
    std::uint64_t received = 0;        ///< packets of any kind
    std::uint64_t accepted = 0;        ///< scene packets
    std::uint64_t malformed = 0;       ///< of a wrong size or magic, or with a time out of range
    std::uint64_t other_versions = 0;  ///< of another version of the protocol
    std::uint64_t foreign = 0;         ///< of another engine than the served one
    std::uint64_t duplicated = 0;      ///< with the number of the last one
    std::uint64_t reordered = 0;       ///< with a lower number
    std::uint64_t leapt = 0;           ///< with a number that is too high to follow
    std::uint64_t lost = 0;            ///< missing numbers, in each session from its first
    std::uint64_t sessions = 0;        ///< of engines, one after another
    std::uint64_t motions = 0;         ///< that objects were given
    std::uint64_t materials = 0;       ///< that objects were given
    std::uint64_t refused_objects = 0; ///< of accepted packets: no such object, no rigid pose, ...
    std::uint64_t sent = 0;            ///< touch packets
    std::uint64_t unsent = 0;          ///< touch packets that the system refused
};

/// The servo thread's. A value that moves.
class EngineChannel {
public:
    EngineChannel(EngineChannel&& other) noexcept;
    EngineChannel& operator=(EngineChannel&& other) noexcept;
    /// Ends the channel and removes the shared memory.
    ~EngineChannel();

    /// Takes the packets that came, and moves objects and changes materials by them: the scene's
    /// objects are left to the engine. Call it before the renderer's tick. Whatever comes, the scene
    /// gets rigid poses within its bounds and materials that build_touch_body takes. noexcept, wait-
    /// free, no allocation, at most 64 packets. \pre seconds > 0
    void receive(TouchScene& scene, double seconds) noexcept;

    /// Sends the last tick. Call it after the device got its force. noexcept, never waits, no
    /// allocation.
    void send(const HapticRenderer& renderer, const DeviceState& state) noexcept;

    [[nodiscard]] const EngineReport& report() const noexcept;

    /// What went wrong, in words; "" for nothing. By the servo thread, outside of ticks.
    [[nodiscard]] std::string trouble() const;

private:
    friend Result<EngineChannel> open_engine_channel(std::string_view name);
    explicit EngineChannel(std::unique_ptr<EngineLink> link) noexcept;

    std::unique_ptr<EngineLink> link_; ///< not null but after a move
};

/// Opens a channel by name:
///     udp:PORT            datagrams of programs on this machine
///     udp:ADDRESS:PORT    also of others, where the address is one of a network
///     shm:NAME            shared memory, for programs of this user
/// Errors: invalid_argument (another name, what the system says, a name or port that is in use).
[[nodiscard]] Result<EngineChannel> open_engine_channel(std::string_view name);

} // namespace proxima
