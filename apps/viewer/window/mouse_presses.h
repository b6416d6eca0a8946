// What a press of GLFW's mouse means to the viewer: which button, and whether it is the second one
// of a double click.
#pragma once

#include "viewer/viewer.h"

#include <chrono>

namespace proxima {

class MousePresses {
public:
    /// GLFW's button and modifiers; a position in the picture's pixels.
    void press(Viewer& viewer, int button, int modifiers, const Vec2& at);

private:
    std::chrono::steady_clock::time_point last_;
    Vec2 last_at_ = Vec2::Zero();
};

} // namespace proxima
