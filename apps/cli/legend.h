// What the colours of a picture mean: a box in its upper right corner.
#pragma once

#include "cli/image.h"

#include <string>
#include <vector>

namespace proxima {

struct LegendEntry {
    unsigned color = 0; ///< 0xRRGGBB
    std::string text;
};

struct Legend {
    std::string title; ///< may be empty
    std::vector<LegendEntry> entries;
};

/// Draws the legend over the picture; nothing without entries, or where it would be wider or higher
/// than half of it.
void draw_legend(Image& image, const Legend& legend);

} // namespace proxima
