// What is shown, in layers: scenes that stand somewhere. A scene is shared and never changes, so
// that whoever draws it uploads it once, however often it moves, fades or is cut.
//
//     mesh A    pose I     ───┐
//     mesh B    pose of B  ───┼──> drawn as one picture; flattened() makes one scene of them
//     cells     pose I     ───┘
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/geometry.h"
#include "viewer/scene.h"

#include <memory>
#include <optional>
#include <span>

namespace proxima {

struct SceneLayer {
    std::shared_ptr<const Scene> scene;
    RigidTransform pose = {};
    std::optional<Color> color = {};   ///< of all its surfaces, in the place of their own
    float opacity = 1.0F;              ///< times their own
    std::optional<HalfSpace> cut = {}; ///< what lies outside is not shown; where it is drawn
};

/// What lies behind everything.
struct Backdrop {
    Color top = srgb(0xFBFCFE);
    Color bottom = srgb(0xE3E8EF);
};

/// One scene of all layers: moved, coloured and cut.
[[nodiscard]] Scene flattened(std::span<const SceneLayer> layers, const Backdrop& backdrop);

/// Of all layers where they stand, uncut; empty without any.
[[nodiscard]] Box bounding_box(std::span<const SceneLayer> layers);

} // namespace proxima
