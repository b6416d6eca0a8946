// The colours that figures share. A's things are red, B's blue, what both sweep is green, as the
// thesis has them.
#pragma once

#include "proxima/octree.h"

namespace proxima::figure_colors {

inline constexpr unsigned ink = 0x222222;
inline constexpr unsigned faint = 0x9AA3AF;
inline constexpr unsigned red = 0xC8373F;
inline constexpr unsigned blue = 0x2F62B5;
inline constexpr unsigned green = 0x2E8B57;
inline constexpr unsigned purple = 0x7F4AA8;
inline constexpr unsigned yellow = 0xE8B800;
inline constexpr unsigned red_tint = 0xF7DCDC;
inline constexpr unsigned blue_tint = 0xDDE7F6;
inline constexpr unsigned green_tint = 0xD9EEDF;
inline constexpr unsigned yellow_tint = 0xFBF1C9;

// Cells of trees.
inline constexpr unsigned boundary_cell = 0xF4B860;
inline constexpr unsigned inner_cell = 0xB9DCC0;
inline constexpr unsigned outer_cell = 0xEEF2F7;

[[nodiscard]] constexpr unsigned cell_color(CellClass type) noexcept
{
    return type == CellClass::boundary ? boundary_cell
           : type == CellClass::inner  ? inner_cell
                                       : outer_cell;
}

} // namespace proxima::figure_colors
