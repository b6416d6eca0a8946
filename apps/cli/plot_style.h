// What plots have in common: colours that everybody tells apart [Tol's bright scheme], and ink.
#pragma once

#include <array>
#include <cstddef>

namespace proxima {

inline constexpr unsigned plot_ink = 0x222222;
inline constexpr unsigned plot_grid = 0xE4E4E4;
inline constexpr std::array plot_palette = {0x4477AAU, 0xEE6677U, 0x228833U,
                                            0xCCBB44U, 0x66CCEEU, 0xAA3377U};

[[nodiscard]] constexpr unsigned plot_color(std::size_t series) noexcept
{
    return plot_palette[series % plot_palette.size()];
}

} // namespace proxima
