// A mesh cut finely, for pictures whose colours change within its triangles.
#pragma once

#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>

namespace proxima {

/// Each triangle cut into n^2 alike, as many as make sides a hundredth of the mesh's diagonal or
/// shorter, n at most 64; or longer where there would be more than `most` triangles. Triangles share no
/// vertices. \pre the mesh has a triangle
[[nodiscard]] Result<TriangleMesh> finely_cut(const TriangleMesh& mesh,
                                              std::uint64_t most = 1'000'000);

} // namespace proxima
