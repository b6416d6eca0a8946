#include "viewer/window/imgui_mouse.h"

#include <algorithm>
#include <imgui.h>
#include <limits>

namespace proxima {
namespace {

constexpr ImguiMouse::Seconds double_click(0.3);

} // namespace

void ImguiMouse::add(int button, bool is_down, const Vec2& at, Time when, Seconds deaf)
{
    static_assert(buttons == ImGuiMouseButton_COUNT);
    if (button < 0 || button >= buttons) return;
    Change change = {.button = button, .is_down = is_down, .at = at};
    if (is_down) {
        Time& last = pressed_[static_cast<std::size_t>(button)];
        change.is_again = when - last < double_click + deaf;
        last = when;
    }
    changes_.push_back(change);
}

void ImguiMouse::set(ImGuiIO& io)
{
    if (!changes_.empty()) {
        const Change change = changes_.front();
        changes_.pop_front();
        is_down_[static_cast<std::size_t>(change.button)] = change.is_down;
        io.MousePos = {static_cast<float>(change.at.x()), static_cast<float>(change.at.y())};
        // ImGui would judge by the frames' times.
        io.MouseDoubleClickTime = change.is_again ? std::numeric_limits<float>::max() : 0.0F;
    }
    std::ranges::copy(is_down_, std::begin(io.MouseDown));
}

} // namespace proxima
