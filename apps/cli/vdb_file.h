// Writes distance fields for OpenVDB, where the program finds the library for it (vdb_library.h).
#pragma once

#include "cli/vdb_library.h"

#include <cstdint>

namespace proxima {

/// Bytes that writing takes at most, beside the field: a leaf of OpenVDB for every 8^3 points.
[[nodiscard]] std::uint64_t vdb_bytes(const PointGrid& grid) noexcept;

/// What writes .vdb files. Error unsupported_format, with advice, where there is no such library.
[[nodiscard]] Result<WriteVdb*> vdb_writer(const std::string& path);

/// Writes a grid of floats called "distance": a level set where the band is finite, and inactive with the
/// band's width as its value beyond. The point (i, j, k) is the voxel (i, j, k); its place is the middle
/// of the voxel, as for all of OpenVDB's level sets. Whole or not at all. Errors: those of vdb_writer,
/// limit_exceeded for distances that floats do not hold, or more than 2^31 - 1 points along an axis,
/// file_not_writable, cancelled.
[[nodiscard]] Status write_vdb(const PointGrid& grid, std::span<const double> distances,
                               double band, const std::string& path, Progress* progress);

} // namespace proxima
