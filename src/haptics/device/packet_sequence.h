// Which packets of which program are heard: those of one program at a time, each newer than the last.
//
//     judge()    foreign, duplicated, reordered, leapt, or well     a new program may begin here
//     accept()   a packet that was judged well is the last one
//
// A program is known by its address and session, a number that it chooses when it starts. The first
// one is served until it leaves, or was silent for `forget_seconds`. With the same address another
// session may begin after `patience`, and with the same session any number after `forget_seconds`.
#pragma once

#include "base/udp_socket.h"

#include <cstdint>

namespace proxima {

enum class PacketVerdict : std::uint8_t {
    well,
    foreign,    ///< of another program than the served one
    duplicated, ///< with the number of the last one
    reordered,  ///< with a lower number
    leapt       ///< with a number that is too high to follow
};

/// One thread. noexcept, no allocation. Times are nanoseconds of a monotonic clock.
class PacketSequence {
public:
    PacketSequence(double patience, double forget_seconds) noexcept
        : patience_(patience), forget_seconds_(forget_seconds)
    {}

    [[nodiscard]] PacketVerdict judge(std::uint64_t session, std::uint64_t sequence,
                                      const UdpAddress& from, std::int64_t now) noexcept;

    /// Takes a packet that was judged well. Returns how many numbers before it never came.
    std::uint64_t accept(std::uint64_t sequence, std::int64_t now) noexcept;

    /// The program said that it ends: another one may begin at once.
    void leave() noexcept { left_ = true; }

    [[nodiscard]] bool serves() const noexcept { return served_; } ///< there is a program
    /// Nothing of the session was accepted yet.
    [[nodiscard]] bool is_first() const noexcept { return first_; }
    [[nodiscard]] std::uint64_t session() const noexcept { return session_; }
    [[nodiscard]] std::uint64_t sequence() const noexcept { return sequence_; } ///< accepted last
    [[nodiscard]] const UdpAddress& peer() const noexcept { return peer_; }
    [[nodiscard]] std::int64_t last_heard() const noexcept { return last_heard_; }
    [[nodiscard]] std::uint64_t sessions() const noexcept { return sessions_; } ///< one by one

private:
    [[nodiscard]] bool is_served(std::uint64_t session, std::uint64_t sequence,
                                 const UdpAddress& from, std::int64_t now) noexcept;

    double patience_;
    double forget_seconds_;
    UdpAddress peer_;
    std::uint64_t session_ = 0;
    std::uint64_t sequence_ = 0;
    std::int64_t last_heard_ = 0;
    std::uint64_t sessions_ = 0;
    bool served_ = false;
    bool left_ = false;
    bool first_ = true;
};

} // namespace proxima
