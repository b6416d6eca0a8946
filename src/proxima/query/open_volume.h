// A view volume about to cull a ray index: its planes in floats, in the index's units.
//
//     n . x + d >= 0   with   x = c + y / s   is   n . y + (n . c + d) s >= 0,  over |n|_1
#pragma once

#include "proxima/geometry/view_volume.h"
#include "proxima/query/ray_index.h"

#include <array>
#include <cstdint>

namespace proxima {

/// A plane of which floats say on which side a point is wherever they are beyond the slack.
struct FloatPlane {
    std::array<float, 3> normal; ///< sizes add up to 1
    float offset;
    float slack;         ///< how far values may be off for points and boxes of the index
    std::uint32_t plane; ///< which of the volume's
};

/// What open_volume says.
enum class VolumeStart : std::uint8_t {
    sees_nothing,
    sees_all, ///< all planes have the whole mesh inside
    ready     ///< to be walked
};

struct OpenVolume {
    std::array<FloatPlane, max_view_planes> planes; ///< those that the mesh is not wholly inside of
    std::uint32_t count;
};

/// Sets everything up.
[[nodiscard]] VolumeStart open_volume(const RayIndex& index, const ViewVolume& volume,
                                      OpenVolume& open) noexcept;

} // namespace proxima
