// Our proximity octree and our mesh index as peers.
#pragma once

#include "proximity_peers.h"

#include <cstdint>

namespace proxima::bench {

/// Built on one thread within a budget, 0: the usual one. Errors: those of the build.
[[nodiscard]] Result<std::unique_ptr<Contender>>
make_proxima_peer(const TriangleMesh& mesh, std::uint64_t bytes_per_triangle = 0);

/// Our mesh index's tree: single queries and batches as they are by default, but on one thread.
[[nodiscard]] Result<std::unique_ptr<Contender>> make_tree_peer(const TriangleMesh& mesh);

} // namespace proxima::bench
