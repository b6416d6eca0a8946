// The packets between an engine, which owns the world, and a renderer, which owns the touch. Both are
// little-endian and described byte by byte in docs/engine_channel.md.
//
//     scene  engine ──▶ renderer    poses, velocities and materials of objects     64 + 144 n bytes
//     touch  renderer ──▶ engine    device, proxy, anchor, force, contacts         576 bytes
#pragma once

#include "haptics/device/packet_bytes.h"
#include "proxima/geometry.h"
#include "proxima/touch_scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

inline constexpr std::uint16_t engine_version = 2;
inline constexpr std::size_t scene_header_size = 64;
inline constexpr std::size_t scene_object_size = 144;
inline constexpr std::size_t most_scene_packet_size =
    scene_header_size + max_scene_objects * scene_object_size;
inline constexpr std::size_t touch_packet_size = 576;

/// An object of a scene packet. Numbers are as they came, perhaps NaN or infinite.
struct PacketObject {
    static constexpr std::uint32_t has_pose = 1;     ///< flag
    static constexpr std::uint32_t has_velocity = 2; ///< flag: of a pose
    static constexpr std::uint32_t has_material = 4; ///< flag

    std::uint32_t object = 0;
    std::uint32_t flags = 0;
    Vec3 position = Vec3::Zero();                    ///< in the scene's unit
    std::array<double, 4> quaternion = {1, 0, 0, 0}; ///< w, x, y, z
    Vec3 velocity = Vec3::Zero();                    ///< of the origin, per second
    Vec3 spin = Vec3::Zero();                        ///< radians per second, axes of the scene
    SurfaceMaterial material;
};

struct ScenePacket {
    static constexpr std::uint32_t leaving = 1; ///< flag: the engine ends its session

    std::uint64_t session = 0;     ///< each start of the engine chooses another number
    std::uint64_t sequence = 0;    ///< each larger than the one before
    std::uint64_t nanoseconds = 0; ///< of the engine's clock, from any origin
    std::uint32_t flags = 0;
    std::uint32_t reply_every = 1; ///< ticks; 0: a single touch packet answers each scene packet
    double period = 0;             ///< s from pose to pose of an object; 0: as the time stamps say
    double material_seconds = 0;   ///< in which materials change
    std::size_t count = 0;
    std::array<PacketObject, max_scene_objects> objects;
};

/// Bits of TouchPacket::flags.
enum TouchFlags : std::uint32_t {
    touch_placed = 1,   ///< the proxy has a position
    touch_squeezed = 2, ///< objects left it none
    touch_jumped = 4,   ///< the device is farther from the last tick than a hand moves
    touch_limited = 8,  ///< the force was cut off at the device's limit
    touch_slewed = 16   ///< or its change
};

struct PacketContact {
    std::uint32_t object = 0;
    std::uint32_t triangle = 0; ///< of the object's mesh
    Vec3 position = Vec3::Zero();
    Vec3 normal = Vec3::Zero();
    double pressure = 0;
};

/// A tick as the engine sees it. Lengths are in the scene's unit, forces in newtons, axes the scene's.
struct TouchPacket {
    std::uint64_t session = 0;            ///< a number that the renderer's program chose
    std::uint64_t sequence = 0;           ///< of the tick, from 1
    std::uint64_t nanoseconds = 0;        ///< of the renderer's clock
    std::uint64_t engine_session = 0;     ///< of the scene packet taken last
    std::uint64_t engine_sequence = 0;    ///< its number; 0 for none
    std::uint64_t engine_nanoseconds = 0; ///< its time stamp
    std::uint64_t accepted = 0;           ///< scene packets
    std::uint64_t lost = 0;               ///< numbers of scene packets that never came
    std::uint64_t refused = 0;            ///< scene packets
    std::uint64_t refused_objects = 0;    ///< of accepted packets
    std::uint64_t unsent = 0;             ///< touch packets that the system did not take
    std::uint32_t condition = 0;          ///< InputCondition
    std::uint32_t flags = 0;              ///< TouchFlags
    std::uint32_t hold = 0;               ///< Hold
    std::uint32_t contact_count = 0;      ///< 0 to 3
    std::uint32_t buttons = 0;
    double units_per_metre = 1; ///< units of the scene for a metre of the device
    Vec3 center = Vec3::Zero(); ///< of the workspace
    Vec3 device = Vec3::Zero();
    std::array<double, 4> rotation = {1, 0, 0, 0}; ///< of the device, w, x, y, z
    Vec3 proxy = Vec3::Zero();
    Vec3 anchor = Vec3::Zero(); ///< what the spring pulls the device to
    Vec3 force = Vec3::Zero();  ///< N, what the device gets
    Vec3 torque = Vec3::Zero(); ///< N m; zero for a point
    Vec3 normal = Vec3::Zero(); ///< of all contacts together
    double depth = 0;
    Vec3 surface_velocity = Vec3::Zero(); ///< m/s
    double force_scale = 0;               ///< the ramps, 0 to 1
    double softness = 1;                  ///< the passivity guard's factor
    double added_damping = 0;             ///< by the passivity guard, N s/m
    std::array<PacketContact, 3> contacts;
};

/// noexcept, no allocation; nothing beyond the span is read, whatever it holds.
[[nodiscard]] PacketFault decode(std::span<const std::byte> bytes, ScenePacket& packet) noexcept;
[[nodiscard]] PacketFault decode(std::span<const std::byte> bytes, TouchPacket& packet) noexcept;

/// Writes the packet's bytes to the front of the buffer, and returns how many. \pre packet.count is at
/// most max_scene_objects
std::size_t encode(const ScenePacket& packet,
                   std::span<std::byte, most_scene_packet_size> bytes) noexcept;
void encode(const TouchPacket& packet, std::span<std::byte, touch_packet_size> bytes) noexcept;

} // namespace proxima
