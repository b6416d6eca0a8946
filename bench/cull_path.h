// What culling along a smooth path of a camera could reuse from frame to frame, counted.
//
//     plain    every frame opens, from the root, the nodes and leaves that a plane cuts
//     front    every K-th frame opens those that a plane may cut within K frames, and keeps the
//              leaves; the frames between look at these alone
#pragma once

#include "proxima/mesh_index.h"
#include "proxima/view_volume.h"

#include <array>
#include <span>
#include <vector>

namespace proxima::bench {

/// How many frames a front is kept for.
inline constexpr std::array<std::size_t, 5> front_frames = {2, 4, 8, 16, 32};

/// Means per frame.
struct PathCounts {
    double plain_nodes = 0;
    double plain_leaves = 0;
    /// Blocks looked at with a front, by front_frames, what makes the front included.
    std::array<double, front_frames.size()> with_front{};
    /// Of the leaves that planes cut, those that were cut in the frame before as well.
    double kept_leaves = 0;
};

/// \pre all volumes have the same number of planes, in the same order
[[nodiscard]] PathCounts count_path(const MeshIndex& index, std::span<const ViewVolume> frames);

} // namespace proxima::bench
