// On which side of a surface a point is, where no feature tells.
#pragma once

#include "index/index_parts.h"
#include "proxima/geometry.h"

namespace proxima {

/// Whether the winding number at p, which is not on the surface, is at least 1/2: by the crossings of
/// a ray where every edge is known to have as many triangles each way, else by an estimate that is
/// sharpened until it tells. No allocation, thread safe. \pre the index has signs, p is finite
[[nodiscard]] bool is_inside_by_winding(const IndexParts& index, const Vec3& p) noexcept;

} // namespace proxima
