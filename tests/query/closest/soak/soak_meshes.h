// What the soak goes through: built-in meshes, scanned ones, and those that hurt.
#pragma once

#include "proxima/triangle_mesh.h"

#include <functional>
#include <string>
#include <vector>

namespace proxima::soak {

/// A mesh that is made or read when its turn comes. An empty one is not there.
struct SoakMesh {
    std::string name;
    std::function<TriangleMesh()> make;
};

/// At least ten that need no file. `seed` is that of the random ones.
[[nodiscard]] std::vector<SoakMesh> soak_meshes(std::uint64_t seed);

} // namespace proxima::soak
