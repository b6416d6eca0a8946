// Our proximity octree as a peer.
#pragma once

#include "proximity_peers.h"

namespace proxima::bench {

/// The budget of a build that names none.
inline constexpr double default_bytes_per_triangle = 600;

/// Built within a budget. Errors: those of the build.
[[nodiscard]] Result<std::unique_ptr<Contender>> make_proxima_peer(const TriangleMesh& mesh,
                                                                   double bytes_per_triangle);

} // namespace proxima::bench
