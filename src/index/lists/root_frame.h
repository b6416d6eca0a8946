// The root cube of closest-feature lists, and its own coordinates: centre 0, half edge in [1/2, 1).
#pragma once

#include "proxima/geometry.h"

namespace proxima {

/// A cube in space with its scale, a power of two.
struct RootFrame {
    Vec3 center = Vec3::Zero();
    double half = 1.0;  ///< half its edge, in the mesh's unit
    double scale = 1.0; ///< mesh's unit to frame's: half * scale is in [1/2, 1)

    /// In the frame's coordinates; one rounding per axis.
    [[nodiscard]] Vec3 to_frame(const Vec3& p) const noexcept { return (p - center) * scale; }

    /// Half the edge in the frame's coordinates.
    [[nodiscard]] double frame_half() const noexcept { return half * scale; }

    /// The closed cube, but for rounding.
    [[nodiscard]] bool contains(const Vec3& p) const noexcept
    {
        return ((p - center).array().abs() <= half).all();
    }
};

/// A cube about the box's centre whose edge is (1 + margin) times the box's longest one. A box that
/// is a point gets an edge as octree roots do. \pre box is not empty, margin >= 0
[[nodiscard]] RootFrame make_root_frame(const Box& box, double margin) noexcept;

} // namespace proxima
