// A view volume about to cull a mesh index: its planes in floats, in the index's units.
//
//     n . x + d >= 0   with   x = c + y / s   is   n . y + (n . c + d) s >= 0,  over |n|_1
#pragma once

#include "index/index_parts.h"
#include "proxima/mesh_index.h"
#include "proxima/view_volume.h"

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

/// What prepare_volume says.
enum class VolumeStart : std::uint8_t {
    sees_nothing,
    sees_all, ///< all planes have the whole mesh inside
    ready     ///< to be walked
};

struct VolumeTraversal {
    std::array<FloatPlane, max_view_planes> planes; ///< those that the mesh is not wholly inside of
    std::uint32_t count;
};

/// Sets everything up.
[[nodiscard]] VolumeStart prepare_volume(const IndexParts& index, const ViewVolume& volume,
                                         VolumeTraversal& open) noexcept;

} // namespace proxima
