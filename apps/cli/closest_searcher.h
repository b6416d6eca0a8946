// What answers `proxima closest`: a mesh index, built or loaded.
#pragma once

#include "cli/session.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <cstdint>
#include <optional>
#include <string>

namespace proxima {

struct ClosestSearcher {
    MeshIndex index;                    ///< with signs where they are asked for
    std::optional<double> load_seconds; ///< of a saved index: mapping and checking it
    double build_seconds = 0;           ///< index and what signs need
};

struct ClosestSearcherOptions {
    bool is_signed = false;
    std::uint64_t list_bytes = 0; ///< at most; 0: no lists
};

/// Builds the searcher of a mesh, with lists where list_bytes is not 0, or of a saved index (.pxi). Errors
/// name the model.
[[nodiscard]] Result<ClosestSearcher> make_closest_searcher(const std::string& model,
                                                            const ClosestSearcherOptions& options,
                                                            Session& session);

} // namespace proxima
