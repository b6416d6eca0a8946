// What answers `proxima closest`: a proximity octree, built or loaded, and what tells signs.
#pragma once

#include "cli/proximity_file_model.h"
#include "cli/session.h"
#include "index/lists/proximity_octree.h"
#include "query/closest/signed_distance.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace proxima {

/// Stays where it is: signs refer to the surface.
struct ClosestSearcher {
    ProximityOctree octree;
    ModelSurface surface; ///< empty where a loaded octree is asked for no signs
    std::optional<SurfaceSign> sign;
    std::optional<double> load_seconds; ///< of a saved octree: mapping and checking it
    double build_seconds = 0;           ///< topology, octree and what signs need
};

struct ClosestSearcherOptions {
    bool is_signed = false;
    std::uint64_t budget_bytes = 0; ///< 0: the library's own
};

/// Of a mesh, or of a saved octree (.pxp), whose own mesh is made again where signs want it. Errors
/// name the model.
[[nodiscard]] Result<std::unique_ptr<ClosestSearcher>>
make_closest_searcher(const std::string& model, const ClosestSearcherOptions& options,
                      Session& session);

} // namespace proxima
