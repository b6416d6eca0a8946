// Options of octrees for tests over many meshes.
#pragma once

#include "proxima/octree.h"

#include <cstdint>
#include <random>

namespace proxima::testing {

/// Depths and thresholds that keep a nasty mesh's octree small.
inline OctreeOptions random_octree_options(std::uint32_t seed)
{
    std::mt19937 random(seed ^ 0x9E3779B9U);
    OctreeOptions options;
    options.max_depth = static_cast<int>(random() % 6);
    options.threshold = random() % 2 == 0 ? 1U : static_cast<std::uint32_t>(random() % 12);
    options.root_shape = random() % 4 == 0 ? RootShape::box : RootShape::cube;
    options.classification = Classification::none;
    options.execution.threads = {1};
    return options;
}

} // namespace proxima::testing
