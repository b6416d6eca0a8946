#include "haptics/device/packet_sequence.h"

namespace proxima {

namespace {

/// More packets than a second has; after a second without a good packet any number is accepted.
constexpr std::uint64_t longest_leap = 65536;

} // namespace

bool PacketSequence::is_served(std::uint64_t session, std::uint64_t sequence,
                               const UdpAddress& from, std::int64_t now) noexcept
{
    const double silent = 1e-9 * static_cast<double>(now - last_heard_);
    const bool same = served_ && from == peer_ && session == session_;
    const bool follows = first_ || (sequence > sequence_ && sequence - sequence_ <= longest_leap);
    if (same && (follows || silent < forget_seconds_)) return true;
    // A sender with the address of the last one is that program again: it need not wait for long.
    const double wait = from == peer_ ? patience_ : forget_seconds_;
    if (served_ && !left_ && silent < wait) return false;
    served_ = true;
    left_ = false;
    first_ = true;
    peer_ = from;
    session_ = session;
    sequence_ = 0;
    ++sessions_;
    return true;
}

PacketVerdict PacketSequence::judge(std::uint64_t session, std::uint64_t sequence,
                                    const UdpAddress& from, std::int64_t now) noexcept
{
    if (!is_served(session, sequence, from, now)) return PacketVerdict::foreign;
    if (first_) return PacketVerdict::well;
    if (sequence == sequence_) return PacketVerdict::duplicated;
    if (sequence < sequence_) return PacketVerdict::reordered;
    return sequence - sequence_ > longest_leap ? PacketVerdict::leapt : PacketVerdict::well;
}

std::uint64_t PacketSequence::accept(std::uint64_t sequence, std::int64_t now) noexcept
{
    const std::uint64_t lost = first_ ? 0 : sequence - sequence_ - 1;
    first_ = false;
    left_ = false;
    sequence_ = sequence;
    last_heard_ = now;
    return lost;
}

} // namespace proxima
