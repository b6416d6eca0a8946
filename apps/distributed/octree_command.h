// proxima-mpi octree: the octree of a mesh that is spread over the ranks.
#pragma once

#include "distributed/world.h"

#include <cstdint>
#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace proxima {

struct OctreeRunOptions {
    std::string model;
    std::string triangles; ///< a .npy file where the model is one of vertices, or empty
    int depth = 5;
    std::uint32_t threshold = 1;
    int routing_depth = 5;
    bool is_verified = false;
    std::string save; ///< a .pxo file, or empty
    std::string out;  ///< a .pvtu file, or empty
};

/// Adds the subcommand. What it returns builds the octree of the parsed arguments' mesh, prints its
/// figures on rank 0 and is collective.
[[nodiscard]] std::function<Status(World&)> add_octree_command(CLI::App& app);

} // namespace proxima
