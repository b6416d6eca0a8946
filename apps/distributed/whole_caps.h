// The caps of a mesh that is spread over the ranks (octree/hole_caps.h).
#pragma once

#include "distributed/mesh_slice.h"
#include "distributed/world.h"

namespace proxima {

/// On all ranks, the caps that hole_caps makes of the whole mesh, bit for bit. Collective; memory
/// and messages are linear in the edges between slices and, on each rank, in those of all holes.
[[nodiscard]] Result<TriangleMesh> whole_caps(const MeshSlice& slice, World& world);

} // namespace proxima
