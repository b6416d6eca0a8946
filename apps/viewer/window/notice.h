// Messages over the lower edge of the picture: problems, and files that were written. They move no
// control when they appear or disappear.
//
//     ┌───────┬────────────────────────────┐
//     │ side- │ picture                    │
//     │ bar   │ ┌────────────────────────┐ │
//     │       │ │ message     hide this  │ │
//     └───────┴─┴────────────────────────┴─┘
#pragma once

#include "proxima/geometry.h"
#include "viewer/window/imgui_controls.h"

#include <string>
#include <vector>

namespace proxima {

class Notice {
public:
    /// Draws within a frame of ImGui. The lower left corner is at (x, y), and longer text scrolls
    /// within `width` and `height`. Without text nothing is drawn. A problem that the person hid
    /// stays hidden until there is another one. Returns true in the frame in which it is hidden.
    [[nodiscard]] bool draw(float x, float y, float width, float height, const std::string& problem,
                            const std::string& news, std::vector<WidgetBounds>& widgets);

    /// Whether it lies over a point of the window.
    [[nodiscard]] bool covers(const Vec2& at) const noexcept
    {
        return (at.array() >= lower_.array()).all() && (at.array() < upper_.array()).all();
    }

private:
    std::string hidden_;        ///< the problem that the person hid
    Vec2 lower_ = Vec2::Zero(); ///< corners of the last drawing; empty without one
    Vec2 upper_ = Vec2::Zero();
};

} // namespace proxima
