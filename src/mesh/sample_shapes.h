// The round samples, watched while they are made. Internal to sample_meshes.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

namespace proxima::detail {

inline constexpr int max_icosphere_subdivisions = 11;

/// As make_sphere, make_icosphere and make_torus. Error cancelled by `progress`, which may be null.
[[nodiscard]] Result<TriangleMesh> sphere(int stacks, int slices, Progress* progress);
[[nodiscard]] Result<TriangleMesh> icosphere(int subdivisions, Progress* progress);
[[nodiscard]] Result<TriangleMesh> torus(int around, int across, Progress* progress);

} // namespace proxima::detail
