// A picture of a mesh with the boundary leaves of its octree: lines coloured by depth; all of it,
// or with the part that a camera sees set off.
#pragma once

#include "cli/camera_options.h"
#include "cli/image.h"
#include "proxima/cull.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <optional>

namespace proxima {

struct PictureOptions {
    CameraChoice view = {};
    /// Where given: triangles that it does not see are drawn dark, and leaves that it does not see
    /// are left out.
    const ViewVolume* volume = nullptr;
    CullMode mode = CullMode::conservative;
    /// For pictures to be compared: a box that fills each, and depths that have the first and the
    /// last colour. Without them the leaves that hold triangles fill it, the coarsest and the
    /// finest of them have these colours.
    std::optional<Box> frame = {};
    std::optional<std::array<int, 2>> depths = {};
    bool with_legend = false; ///< what the colours mean, in the upper right corner
    Execution execution = {}; ///< stages "drawing the mesh", "shading" and "drawing the cells"
};

/// Draws the mesh, shaded, and the edges of the leaves that hold triangles. A mesh without triangles
/// leaves the cells alone. Errors: cancelled, budget_exceeded, and those of placed_camera. \pre octree was built from
/// the mesh unless that has no triangles, sizes are positive
[[nodiscard]] Result<Image> draw_octree(const Octree& octree, const TriangleMesh& mesh,
                                        const PictureOptions& options = {});

} // namespace proxima
