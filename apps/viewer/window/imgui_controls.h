// Controls as widgets of Dear ImGui, and where each of them is in the window.
#pragma once

#include "viewer/controls.h"

#include <string>
#include <vector>

namespace proxima {

/// A widget of this frame, in the window's coordinates.
struct WidgetBounds {
    std::string name;
    std::string value;
    float x = 0;
    float y = 0;
    float width = 0;
    float height = 0;
    std::string needs = {}; ///< why it is disabled; else empty
};

/// Notes where the last widget is.
void add_widget(const std::string& name, std::string value, std::vector<WidgetBounds>& widgets);

/// Text that begins a new line at the window's end.
void wrapped(std::string_view text);
/// The same in red.
void wrapped_problem(std::string_view text);

/// As much of the text's end as one line holds, after "..." where its beginning is left out; the mouse over
/// it shows the whole. So that what stands below does not move as the text changes. The text is UTF-8.
void end_of_line(std::string_view text);

/// To be used within a window of ImGui, anew for each frame.
class ImguiControls final : public Controls {
public:
    bool toggle(std::string_view name, bool& value) override;
    bool number(std::string_view name, int& value, int least, int most) override;
    bool number(std::string_view name, double& value, double least, double most) override;
    bool choice(std::string_view name, std::size_t& value,
                std::span<const std::string_view> words) override;
    bool text(std::string_view name, std::string& value) override;
    bool button(std::string_view name) override;
    /// Controls whose condition is not met are disabled, and say it under the mouse.
    void begin_condition(std::string_view words, bool is_met) override;
    void end_condition() override;

    [[nodiscard]] const std::vector<WidgetBounds>& widgets() const noexcept { return widgets_; }
    [[nodiscard]] bool changed() const noexcept { return changed_; }

private:
    bool note(std::string_view name, std::string value, bool changed);

    std::string unmet_; ///< the present condition
    std::vector<WidgetBounds> widgets_;
    bool changed_ = false;
};

} // namespace proxima
