// proxima-mpi octree: the octree of a mesh that is spread over the ranks.
#pragma once

#include "distributed/world.h"

#include <cstdint>
#include <string>

namespace proxima {

struct OctreeRunOptions {
    std::string model;
    int depth = 5;
    std::uint32_t threshold = 1;
    int routing_depth = 5;
    bool is_verified = false;
};

/// Builds the octree and prints its size on rank 0. Collective.
[[nodiscard]] Status run_octree(const OctreeRunOptions& options, World& world);

} // namespace proxima
