#include "viewer/window/mouse_presses.h"

#include <GLFW/glfw3.h>

namespace proxima {

void MousePresses::press(Viewer& viewer, int button, int modifiers, const Vec2& at)
{
    constexpr std::chrono::milliseconds double_click(350);
    constexpr double same_position = 5.0; // pixels
    const MouseButton pressed = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::left
                                : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::right
                                                                    : MouseButton::middle;
    const auto now = std::chrono::steady_clock::now();
    const bool again = pressed == MouseButton::left && now - last_ < double_click &&
                       (at - last_at_).norm() < same_position;
    last_ = now;
    last_at_ = at;
    if (again) {
        viewer.double_click(at);
    } else {
        viewer.press(pressed, at, (modifiers & GLFW_MOD_SHIFT) != 0);
    }
}

} // namespace proxima
