// Whether a saved mesh index is what its file says, and answers as its triangles do.
#pragma once

#include "cli/session.h"
#include "proxima/result.h"

#include <string>

namespace proxima {

/// Checks the file's checksums and structure, that edges are those of its mesh, its answers at 60
/// to 3,000 points against all triangles and, where `mesh` is named, that the index is of that
/// one. Errors: those of load_index, load_model, check_same_mesh and check_answers.
[[nodiscard]] Status check_index_file(const std::string& path, const std::string& mesh,
                                      Session& session);

} // namespace proxima
