// What pictures show: meshes shaded by lamps, and boxes by their edges. What is behind the eye is cut
// off.
#pragma once

#include "cli/camera.h"
#include "cli/canvas.h"
#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <functional>

namespace proxima {

/// The colour of a triangle's surface.
using SurfaceColor = std::function<Color(TriangleId)>;

/// Draws the mesh shaded, in the clay colour of all pictures unless colours are given. Stage "drawing the mesh".
void draw_mesh(Canvas& canvas, const View& view, const TriangleMesh& mesh,
               const SurfaceColor& color, Progress* progress);

/// The corners of a box, which may be turned; numbered as corners(Box) does.
using BoxCorners = std::array<Vec3, 8>;

/// Draws the edges of the faces that the eye sees; of all faces where it is inside.
void draw_box_edges(Canvas& canvas, const View& view, const BoxCorners& box, const Color& color,
                    const LineStyle& style);

/// Hides lines that are drawn later behind the faces that the eye sees.
void hide_lines_behind(Canvas& canvas, const View& view, const BoxCorners& box);

/// Draws the part of a segment that is in front of the eye.
void draw_segment(Canvas& canvas, const View& view, const Vec3& from, const Vec3& to,
                  const Color& color, const LineStyle& style);

} // namespace proxima
