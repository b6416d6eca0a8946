// Whether a saved octree is what its file says.
#pragma once

#include "cli/session.h"
#include "proxima/result.h"

#include <string>

namespace proxima {

/// Checks the file's checksums and structure and, where `mesh` is named, all invariants of
/// check_octree against it. Errors: those of load_octree_file and load_mesh_of; broken_invariant.
[[nodiscard]] Status check_octree_file(const std::string& path, const std::string& mesh,
                                       Session& session);

} // namespace proxima
