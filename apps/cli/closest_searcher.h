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
    bool lists = false;           ///< of a mesh; a saved index keeps what it has
    std::uint64_t list_bytes = 0; ///< of the lists at most; 0: the usual budget
};

/// Builds the index of a mesh, or loads a saved one (.pxi). Errors name the model.
[[nodiscard]] Result<ClosestSearcher> make_closest_searcher(const std::string& model,
                                                            const ClosestSearcherOptions& options,
                                                            Session& session);

} // namespace proxima
