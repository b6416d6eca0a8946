// The strip at the window's left: the work in progress, the panel's controls, files to write, facts
// and plots.
#pragma once

#include "viewer/viewer.h"
#include "viewer/window/imgui_controls.h"

#include <string>
#include <vector>

namespace proxima {

/// What a person asked for in this frame, beside changed settings.
struct SidebarWishes {
    bool open = false; ///< the panel that opens models
    bool cancel = false;
    std::string picture; ///< a file to write
    std::string glb;     ///< a file to write
};

class Sidebar {
public:
    /// Within a frame of ImGui; bounds of its widgets are added to `widgets`.
    [[nodiscard]] SidebarWishes draw(Viewer& viewer, float width, float height,
                                     std::vector<WidgetBounds>& widgets);

private:
    std::string picture_ = "view.png";
    std::string glb_ = "view.glb";
};

} // namespace proxima
