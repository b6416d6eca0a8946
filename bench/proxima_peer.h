// Our mesh index as a peer: its tree alone, as it is by default, or with lists.
#pragma once

#include "proximity_peers.h"

#include <cstdint>

namespace proxima::bench {

/// Built on one thread: "lists" within a budget, or the "tree" alone where that is 0. Batches are
/// searched on one thread too. Errors: those of the build.
[[nodiscard]] Result<std::unique_ptr<Contender>>
make_proxima_peer(const TriangleMesh& mesh, std::uint64_t list_bytes_per_triangle);

/// The tree alone; each single query starts from the answer of the last one. Errors: those of the build.
[[nodiscard]] Result<std::unique_ptr<Contender>> make_warm_proxima_peer(const TriangleMesh& mesh);

} // namespace proxima::bench
