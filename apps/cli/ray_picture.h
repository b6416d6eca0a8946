// Pictures of a camera's rays: the weights of the cells that each goes through (figures 5.5 and 5.6
// of the thesis, for every pixel), or the triangle that it hits first, shaded.
#pragma once

#include "cli/image.h"
#include "cli/ray_sources.h"
#include "proxima/cast_ray.h"
#include "proxima/execution.h"
#include "proxima/octree.h"

#include <cstddef>
#include <optional>
#include <span>

namespace proxima {

/// From black to pale yellow by the weight of the cells with triangles that a pixel's ray goes
/// through, the sum of penetration * chord / edge; pale yellow are the largest hundredth of those
/// above zero. Unfinished where progress is cancelled. \pre a ray per pixel
[[nodiscard]] Image draw_weights(const Octree& octree, const RayList& rays, ViewSize size,
                                 Threads threads, Progress* progress);

/// With room for its pixels, and none of them yet.
[[nodiscard]] Image empty_image(ViewSize size);

/// Draws the next pixels of the image, by the angle between ray and face; back faces are bluish.
/// \pre a ray for each hit
void draw_hits(const TriangleMesh& mesh, std::span<const Ray> rays,
               std::span<const std::optional<RayHit>> hits, Image& image);

} // namespace proxima
