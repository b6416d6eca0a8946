// proxima closest --method thesis: answers by the thesis's proximity octree (thesis 4.3).
#pragma once

#include "cli/point_options.h"
#include "cli/session.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <string>

namespace proxima {

struct ThesisClosestOptions {
    std::string model;
    PointOptions points;
    std::string out;    ///< "-" for stdout, empty for none
    std::string octree; ///< a saved octree to ask, empty to build one
    std::string save;
    int depth = ThesisProximityOptions{}.max_depth;
};

/// Builds the octree or opens a saved one, asks it, and writes the answers. Points inside the mesh
/// or outside the root have none, and no row. Errors: invalid_mesh for a mesh that is not convex.
[[nodiscard]] Status run_thesis_closest(const ThesisClosestOptions& options, Session& session);

} // namespace proxima
