// What a press of GLFW's mouse means to the viewer: which button, and whether it is the second one
// of a double click.
#pragma once

#include "viewer/viewer.h"

#include <chrono>
#include <optional>

namespace proxima {

class MousePresses {
public:
    /// GLFW's button and modifiers; a position in the picture's pixels.
    void press(Viewer& viewer, int button, int modifiers, const Vec2& at);
    /// A press that was dragged away is not the first of a double click.
    void release(Viewer& viewer, const Vec2& at);

private:
    struct Press {
        std::chrono::steady_clock::time_point when;
        Vec2 at;
    };
    std::optional<Press> last_;
};

} // namespace proxima
