// The sets of rays that casting is timed with.
//
//     coherent    primary rays of a square camera, the model's longest side filling the frame,
//                 row by row
//     incoherent  between two points uniform on the sphere around the mesh's box
//
// All numbers are floats, so that every peer casts the same rays.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"
#include "ray_peers.h"

#include <array>
#include <cstdint>
#include <vector>

namespace proxima::bench {

struct RaySet {
    const char* name;
    Coherence coherence;
    std::vector<Ray> rays;
};

/// `side` * `side` rays each. The same for the same mesh and seed.
[[nodiscard]] std::array<RaySet, 2> ray_sets(const TriangleMesh& mesh, std::size_t side,
                                             std::uint64_t seed);

/// The mesh with positions rounded to floats: what all peers can hold.
[[nodiscard]] TriangleMesh rounded_to_floats(const TriangleMesh& mesh);

} // namespace proxima::bench
