// The legend as a box of Dear ImGui in the upper right corner of the picture.
#pragma once

#include "cli/legend.h"
#include "viewer/window/imgui_controls.h"

#include <vector>

namespace proxima {

/// `right` and `top` are the box's corner in the window's coordinates. Nothing without entries.
void draw_legend_box(const Legend& legend, float right, float top,
                     std::vector<WidgetBounds>& widgets);

} // namespace proxima
