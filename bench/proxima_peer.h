// Our proximity octree as a peer.
#pragma once

#include "proximity_peers.h"

#include <cstdint>

namespace proxima::bench {

/// Built on one thread within a budget, 0: the usual one. Errors: those of the build.
[[nodiscard]] Result<std::unique_ptr<Contender>>
make_proxima_peer(const TriangleMesh& mesh, std::uint64_t bytes_per_triangle = 0);

} // namespace proxima::bench
