#include "viewer/window/mouse_presses.h"

#include <GLFW/glfw3.h>

namespace proxima {
namespace {

constexpr std::chrono::milliseconds double_click(350);
constexpr double same_position = 5.0; // pixels

} // namespace

void MousePresses::press(Viewer& viewer, int button, int modifiers, const Vec2& at)
{
    const MouseButton pressed = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::left
                                : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::right
                                                                    : MouseButton::middle;
    const auto now = std::chrono::steady_clock::now();
    const bool again = pressed == MouseButton::left && last_ && now - last_->when < double_click &&
                       (at - last_->at).norm() < same_position;
    last_ = Press{.when = now, .at = at};
    if (again) {
        viewer.double_click(at);
    } else {
        viewer.press(pressed, at, (modifiers & GLFW_MOD_SHIFT) != 0);
    }
}

void MousePresses::release(Viewer& viewer, const Vec2& at)
{
    if (last_ && (at - last_->at).norm() >= same_position) last_.reset();
    viewer.release(at);
}

} // namespace proxima
