// Writes binary glTF 2.0: 12 bytes of header, a JSON chunk, and one buffer of the parts' points and
// indices. Numbers are little-endian floats and 32-bit integers, so everything is aligned to 4.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// Triangles or lines of one colour.
struct GlbPart {
    enum class Mode : std::uint8_t { lines = 1, triangles = 4 };

    std::string name;
    Mode mode = Mode::triangles;
    std::array<double, 3> colour{}; ///< red, green, blue in [0, 1]
    double opacity = 1;             ///< in [0, 1]
    std::vector<std::array<float, 3>> points;
    std::vector<std::uint32_t> indices;
    std::array<float, 3> lower{};
    std::array<float, 3> upper{};
    bool finite = true; ///< false once a coordinate was beyond float

    /// Appends a position, relative to the origin of the file.
    void add_point(const Vec3& point, const Vec3& origin);
};

/// Writes the parts that have indices, each as a node moved to the origin; whole or not at all.
/// Errors: limit_exceeded (a coordinate beyond float, more than 4 GB), file_not_writable,
/// cancelled.
[[nodiscard]] Status write_glb(std::span<const GlbPart> parts, const Vec3& origin,
                               const std::filesystem::path& path, Progress* progress = nullptr);

} // namespace proxima
