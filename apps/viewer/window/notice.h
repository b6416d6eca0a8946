// What went wrong and what was written, in words over the picture's lower edge: coming and going it
// moves no control.
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
    /// Within a frame of ImGui. Its lower left corner is at (x, y); no wider and higher than that:
    /// longer text scrolls. Nothing is shown for no words, and for a problem that was hidden until
    /// it is another one. True where it was hidden just now.
    [[nodiscard]] bool draw(float x, float y, float width, float height, const std::string& problem,
                            const std::string& news, std::vector<WidgetPlace>& places);

    /// Whether it lies over a place of the window.
    [[nodiscard]] bool covers(const Vec2& at) const noexcept
    {
        return (at.array() >= lower_.array()).all() && (at.array() < upper_.array()).all();
    }

private:
    std::string hidden_;        ///< the problem that was
    Vec2 lower_ = Vec2::Zero(); ///< of where it was drawn last; empty if it was not
    Vec2 upper_ = Vec2::Zero();
};

} // namespace proxima
