// The baseline without a proxy: a point that is pushed out where the surface is nearest.
//
//     outside   nothing              inside   F = K d n - B (v . n) n,  n towards the nearest place
//
// It remembers nothing of where it came in, and has the faults that proxies were invented against
// [zilles-1995]: deep inside, another side becomes the nearest and the force jumps; a thin wall
// pushes out on its far side, or is leapt over within a tick. Neither friction, radius nor shading.
#pragma once

#include "haptics/proxy/proxy.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"

#include <array>
#include <cstddef>
#include <span>

namespace proxima {

/// What knows the nearest place and the inside. Refers to both, of the same mesh.
struct PenaltySurface {
    const MeshIndex* index = nullptr;
    const SurfaceSign* sign = nullptr;
};

/// One thread. noexcept, no allocation; a closest feature and its sign per tick.
class PenaltyProbe {
public:
    /// \pre both are there
    explicit PenaltyProbe(const PenaltySurface& surface);

    /// Begins there, as if it came from nowhere. \pre p is finite
    void place(const Vec3& p) noexcept;

    /// What is felt, as a proxy would say it, which is the device itself: inside, its anchor is the
    /// nearest place of the surface, and it slides. \pre placed; p is finite
    const ProxyTick& follow(const Vec3& p) noexcept;

    /// What follow() answered last.
    [[nodiscard]] const ProxyTick& last() const noexcept { return tick_; }

    /// Whether in the last tick it was pushed against the side on which it was pushed before.
    [[nodiscard]] bool popped() const noexcept { return popped_; }

    /// The device's straight way in the last tick, where nothing was felt at its ends: what lies on
    /// it was leapt over.
    [[nodiscard]] std::span<const Vec3> path() const noexcept
    {
        return std::span(path_).first(path_size_);
    }

private:
    PenaltySurface surface_;
    ProxyTick tick_;
    bool popped_ = false;
    std::array<Vec3, 2> path_;
    std::size_t path_size_ = 0;
};

} // namespace proxima
