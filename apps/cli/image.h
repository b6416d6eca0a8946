// A picture in memory, and how it becomes a PNG file.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima {

/// Rows from the top, three bytes per pixel (red, green, blue), sRGB.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> bytes;

    /// \pre 0 <= x < width, 0 <= y < height
    [[nodiscard]] std::array<std::uint8_t, 3> pixel(int x, int y) const noexcept
    {
        const std::size_t first =
            3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(x));
        return {bytes[first], bytes[first + 1], bytes[first + 2]};
    }
};

/// Writes `image` as PNG, whole or not at all. Errors: file_not_writable, cancelled.
[[nodiscard]] Status write_png(const Image& image, const std::string& path,
                               Progress* progress = nullptr);

} // namespace proxima
