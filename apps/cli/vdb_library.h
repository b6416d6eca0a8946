// The library that writes .vdb files for the program, which is opened when one is asked for: OpenVDB and
// what it needs take longer to load than most commands take.
#pragma once

#include "proxima/distance_field.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <span>
#include <string>

namespace proxima {

/// What the library exports: write_vdb (vdb_file.h), its result written to `status`.
using WriteVdb = void(const PointGrid& grid, std::span<const double> distances, double band,
                      const std::string& path, Progress* progress, Status& status);

inline constexpr const char* write_vdb_name = "proxima_write_vdb";

} // namespace proxima
