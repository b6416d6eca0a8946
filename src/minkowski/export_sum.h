// Minkowski sums for other programs, facets told apart by where they come from (thesis figures 3.8
// to 3.11).
//
//     .obj   polygons, a group and a material name for each origin
//     .ply   polygons with a colour each; doubles
//     .glb   a part for each origin, in its colour; floats relative to the first corner
//
// Red facets are A's, blue ones B's, purple ones of both, green ones swept.
#pragma once

#include "proxima/execution.h"
#include "proxima/minkowski_sum.h"
#include "proxima/result.h"

#include <array>
#include <filesystem>
#include <string_view>

namespace proxima {

/// "a", "b", "both", "swept".
[[nodiscard]] std::string_view name_of(FacetOrigin origin) noexcept;

/// Red, green, blue, 0 to 255.
[[nodiscard]] std::array<std::uint8_t, 3> colour_of(FacetOrigin origin) noexcept;

struct SumExportOptions {
    double ray_length = 1; ///< how long rays are drawn
    Execution execution = {};
};

/// Error unsupported_format where export_sum could not write to a file of this name.
[[nodiscard]] Status check_sum_format(const std::filesystem::path& path);

/// Writes the format that the extension names, whole or not at all. Errors: unsupported_format,
/// invalid_argument (a sum without polygons), limit_exceeded, file_not_writable, cancelled.
[[nodiscard]] Status export_sum(const MinkowskiSum& sum, const std::filesystem::path& path,
                                const SumExportOptions& options = {});

} // namespace proxima
