// The mouse's buttons for ImGui, which looks at them once per frame: where frames take long it would
// take two clicks for one, or for none.
#pragma once

#include "proxima/geometry.h"

#include <array>
#include <chrono>
#include <deque>

struct ImGuiIO;

namespace proxima {

class ImguiMouse {
public:
    using Seconds = std::chrono::duration<double>;
    using Time = std::chrono::steady_clock::time_point;

    /// A button of ImGui was pressed or let go at a point of the window. It was heard of at `when`,
    /// and may have come as long before as nobody listened.
    void add(int button, bool is_down, const Vec2& at, Time when, Seconds deaf);

    /// Sets the buttons for one frame of ImGui, between the backend's and its own NewFrame: each
    /// press and each release has a frame of its own, where it came.
    void set(ImGuiIO& io);

    /// Whether there is more to be set in further frames.
    [[nodiscard]] bool has_more() const noexcept { return !changes_.empty(); }

private:
    struct Change {
        int button = 0;
        bool is_down = false;
        bool is_again = false; ///< may be the second press of a double-click
        Vec2 at = Vec2::Zero();
    };
    static constexpr int buttons = 5; ///< of ImGui

    std::deque<Change> changes_; ///< not yet set
    std::array<bool, buttons> is_down_{};
    std::array<Time, buttons> pressed_{}; ///< when it was heard of last
};

} // namespace proxima
