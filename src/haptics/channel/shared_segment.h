// A named segment of shared memory that one program owns and others map, and the rings in it. Offsets
// in bytes, numbers little-endian, all described in docs/engine_channel.md.
//
//     header    256 bytes: magic, version, endianness, sizes, owner, and the two counts
//     touch     1,024 slots of 640 bytes    owner ──▶ engine
//     scene        64 slots of 9,344 bytes  engine ──▶ owner
//
// Packet n, from 0, is in slot n modulo the number of slots. A slot begins with a number: 2n + 1 while
// packet n is being written, 2n + 2 once it is there. These are absolute, so a writer that dies leaves
// nothing locked: who comes next writes its own numbers. A reader copies the packet and looks at the
// number again: a packet that was overwritten meanwhile is dropped. Nobody waits.
//
// The owner holds a lock (flock) on the segment, which ends with its process: a segment without that
// lock is stale and is taken over. Engines ask for a shared lock to see whether it is. The owner removes
// the name when it ends.
#pragma once

#include "haptics/channel/engine_packets.h"
#include "haptics/channel/truncation_guard.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace proxima {

/// A ring of packets in a segment.
struct RingLayout {
    std::uint32_t offset = 0;
    std::uint32_t slot_size = 0;
    std::uint32_t slots = 0;        ///< a power of two
    std::uint32_t count_offset = 0; ///< of the number of packets that were written, u64
};

inline constexpr std::size_t segment_header_size = 256;
inline constexpr RingLayout touch_ring = {segment_header_size, 640, 1024, 64};
inline constexpr RingLayout scene_ring = {
    touch_ring.offset + touch_ring.slot_size * touch_ring.slots, 9344, 64, 128};
inline constexpr std::size_t segment_size =
    scene_ring.offset + std::size_t{scene_ring.slot_size} * scene_ring.slots;
static_assert(8 + touch_packet_size <= touch_ring.slot_size);
static_assert(8 + most_scene_packet_size <= scene_ring.slot_size);

/// Writes packet `number` to a ring, and then their count. noexcept, wait-free. By one thread of one
/// process. \pre the packet fits a slot, and the memory begins at a multiple of 8
void write_packet(std::span<std::byte> segment, const RingLayout& ring, std::uint64_t number,
                  std::span<const std::byte> packet) noexcept;

/// Copies packet `number` from a ring, as much as the buffer holds. Returns the size that its header
/// tells, at most that of a slot; 0 where it is not there, or no longer. noexcept, wait-free,
/// whatever the memory holds and whoever writes to it. \pre the buffer holds at least 8 bytes
[[nodiscard]] std::size_t read_packet(std::span<const std::byte> segment, const RingLayout& ring,
                                      std::uint64_t number, std::span<std::byte> buffer) noexcept;

/// How many packets were written to a ring, as its writer tells.
[[nodiscard]] std::uint64_t packets_written(std::span<const std::byte> segment,
                                            const RingLayout& ring) noexcept;

/// The owner's side. Removes the name in the destructor.
class SharedSegment {
public:
    /// Makes the segment "/proxima-NAME", that only this user may open, or takes over a stale one.
    /// Errors invalid_argument: the name is in use by a program that runs, or by something else than
    /// such a segment; what the system says.
    [[nodiscard]] static Result<SharedSegment> create(std::string_view name);

    SharedSegment(SharedSegment&& other) noexcept;
    SharedSegment& operator=(SharedSegment&& other) noexcept;
    ~SharedSegment();

    [[nodiscard]] std::span<std::byte> bytes() const noexcept { return bytes_; }
    [[nodiscard]] const std::string& path() const noexcept { return path_; } ///< "/proxima-NAME"
    /// Whether another program shortened the segment: then nobody hears the other any more.
    [[nodiscard]] bool is_cut_off() const noexcept { return guard_.has_acted(); }

private:
    SharedSegment() = default;

    std::string path_;
    int file_ = -1;
    std::span<std::byte> bytes_;
    TruncationGuard guard_;
};

} // namespace proxima
