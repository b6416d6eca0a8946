// Layers: scenes with a pose, a colour, an opacity and a cut. Scenes are shared and never change.
// So a renderer uploads each scene once, however often its layer is moved, faded or cut.
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
    std::shared_ptr<const DrawnScene> scene;
    RigidTransform pose = {};
    std::optional<Color> color = {};   ///< of all its surfaces, instead of their own
    float opacity = 1.0F;              ///< times their own
    std::optional<HalfSpace> cut = {}; ///< hides what lies outside; in coordinates after the pose
};

/// What lies behind everything.
struct Backdrop {
    Color top = srgb(0xFBFCFE);
    Color bottom = srgb(0xE3E8EF);
};

/// One scene of all layers: moved, coloured and cut.
[[nodiscard]] DrawnScene flattened(std::span<const SceneLayer> layers, const Backdrop& backdrop);

/// The box about all layers at their poses, without cuts; empty without layers.
[[nodiscard]] Box bounding_box(std::span<const SceneLayer> layers);

} // namespace proxima
