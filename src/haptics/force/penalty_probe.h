// The baseline without a proxy: a point that is pushed out where the surface is nearest.
//
//     outside   nothing              inside   F = K d n - B (v . n) n,  n towards the nearest point
//
// It does not remember where it entered, and has the faults that proxies were invented against
// [zilles-1995]: deep inside, another side becomes the nearest and the force jumps; a thin wall
// pushes out on its far side, or is passed within a tick. It has no friction, radius or shading.
#pragma once

#include "haptics/proxy/proxy.h"
#include "proxima/mesh_index.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// What the spring of a session pulls towards.
enum class ForceLaw : std::uint8_t {
    proxy,  ///< a proxy that stays outside
    penalty ///< the nearest point of the surface
};

/// One thread. noexcept, no allocation; a signed distance per tick.
class PenaltyProbe {
public:
    /// \pre the index has signs
    explicit PenaltyProbe(const MeshIndex& index);

    /// Starts at p, without a past. \pre p is finite
    void place(const Vec3& p) noexcept;

    /// A tick in the form of a proxy's, with the device itself as the proxy: inside, its anchor is the
    /// nearest point of the surface, and it slides. \pre placed; p is finite
    const ProxyTick& follow(const Vec3& p) noexcept;

    /// What follow() returned last.
    [[nodiscard]] const ProxyTick& last() const noexcept { return tick_; }

    /// Whether the last tick pushed against the side of the tick before.
    [[nodiscard]] bool popped() const noexcept { return popped_; }

    /// The device's straight path in the last tick if both ends are outside: surfaces on it were
    /// passed.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return std::span(path_).first(path_size_);
    }

private:
    MeshIndex index_;
    ProxyTick tick_;
    bool popped_ = false;
    std::array<Vec3, 2> path_;
    std::size_t path_size_ = 0;
};

} // namespace proxima
