// Poses of a mesh against itself: turned anyhow, and overlapping, nearly apart or barely touching.
#pragma once

#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace proxima::bench {

struct PoseSet {
    const char* name;
    std::vector<RigidTransform> poses;
};

/// 60 whose translation brings a random point near the surface of one onto one of the other's; 20
/// just apart and 20 just touching, by 1e-3 of the mesh's size along the way on which they come
/// together. The same for the same seed.
[[nodiscard]] std::vector<PoseSet> contact_poses(const TriangleMesh& mesh, const MeshIndex& index,
                                                 std::uint64_t seed);

} // namespace proxima::bench
