// Poses that a command reads: rows of 12 numbers, the 3 x 4 matrix (R | t) row by row.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <string>
#include <vector>

namespace proxima {

/// From CSV or .npy. Errors as read_number_table, and invalid_argument for a row that is no rigid
/// transform, naming its line (of .npy its row, from 0).
[[nodiscard]] Result<std::vector<RigidTransform>> read_poses(const std::string& path,
                                                             Progress* progress);

} // namespace proxima
