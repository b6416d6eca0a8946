// Whether a saved proximity octree is what its file says, and answers as its triangles do.
#pragma once

#include "cli/session.h"
#include "proxima/result.h"

#include <string>

namespace proxima {

/// Checks the file's checksums and structure, that edges are those of its mesh, its answers at 60
/// to 3,000 places against all triangles and, where `mesh` is named, that the octree is of that
/// one. Errors: those of load_proximity_octree, load_model, check_same_mesh and check_answers.
[[nodiscard]] Status check_proximity_file(const std::string& path, const std::string& mesh,
                                          Session& session);

} // namespace proxima
