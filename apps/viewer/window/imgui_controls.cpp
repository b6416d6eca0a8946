#include "viewer/window/imgui_controls.h"

#include "base/text.h"
#include "cli/printable.h"
#include "viewer/window/input_text.h"

#include <algorithm>
#include <imgui.h>

namespace proxima {
namespace {

/// The name left of the widget, which takes the rest of the line.
std::string label(std::string_view name)
{
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(name.data(), name.data() + name.size());
    ImGui::SameLine(0.42F * ImGui::GetWindowContentRegionMax().x);
    ImGui::SetNextItemWidth(-1.0F);
    return concat("##", name);
}

} // namespace

void add_widget(const std::string& name, std::string value, std::vector<WidgetBounds>& widgets)
{
    const ImVec2 lower = ImGui::GetItemRectMin();
    const ImVec2 upper = ImGui::GetItemRectMax();
    widgets.push_back(
        {name, std::move(value), lower.x, lower.y, upper.x - lower.x, upper.y - lower.y});
}

void wrapped(std::string_view text)
{
    ImGui::PushTextWrapPos(0.0F);
    ImGui::TextUnformatted(text.data(), text.data() + text.size());
    ImGui::PopTextWrapPos();
}

void wrapped_problem(std::string_view text)
{
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.85F, 0.25F, 0.2F, 1.0F));
    wrapped(text);
    ImGui::PopStyleColor();
}

void end_of_line(std::string_view text)
{
    const auto width = [](std::string_view part) {
        return ImGui::CalcTextSize(part.data(), part.data() + part.size()).x;
    };
    constexpr std::string_view left_out = "...";
    const float room = ImGui::GetContentRegionAvail().x;
    if (width(text) <= room) {
        ImGui::TextUnformatted(text.data(), text.data() + text.size());
        return;
    }
    std::string_view end = text;
    do {
        end.remove_prefix(std::max<std::size_t>(1, utf8_length(end)));
    } while (!end.empty() && width(left_out) + width(end) > room);
    const std::string shown = concat(left_out, end);
    ImGui::TextUnformatted(shown.data(), shown.data() + shown.size());
    if (!ImGui::IsItemHovered()) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(35.0F * ImGui::GetFontSize());
    ImGui::TextUnformatted(text.data(), text.data() + text.size());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

bool ImguiControls::note(std::string_view name, std::string value, bool changed)
{
    add_widget(std::string(name), std::move(value), widgets_);
    if (!unmet_.empty()) {
        widgets_.back().needs = unmet_;
        if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
            ImGui::SetTooltip("needs %s", unmet_.c_str());
    }
    changed_ = changed_ || changed;
    return changed;
}

void ImguiControls::begin_condition(std::string_view words, bool is_met)
{
    unmet_ = is_met ? "" : std::string(words);
    ImGui::BeginDisabled(!is_met);
}

void ImguiControls::end_condition()
{
    unmet_.clear();
    ImGui::EndDisabled();
}

bool ImguiControls::toggle(std::string_view name, bool& value)
{
    const bool changed = ImGui::Checkbox(std::string(name).c_str(), &value);
    return note(name, value ? "on" : "off", changed);
}

bool ImguiControls::number(std::string_view name, int& value, int least, int most)
{
    const std::string id = label(name);
    const bool changed =
        ImGui::SliderInt(id.c_str(), &value, least, most, "%d", ImGuiSliderFlags_AlwaysClamp);
    return note(name, concat(value), changed);
}

bool ImguiControls::number(std::string_view name, double& value, double least, double most)
{
    const std::string id = label(name);
    const bool changed = ImGui::SliderScalar(id.c_str(), ImGuiDataType_Double, &value, &least,
                                             &most, "%.3g", ImGuiSliderFlags_AlwaysClamp);
    return note(name, concat(value), changed);
}

bool ImguiControls::choice(std::string_view name, std::size_t& value,
                           std::span<const std::string_view> words)
{
    const std::string id = label(name);
    const std::string shown(value < words.size() ? words[value] : "");
    bool changed = false;
    const bool open = ImGui::BeginCombo(id.c_str(), shown.c_str(), ImGuiComboFlags_HeightLargest);
    note(name, shown, false);
    if (open) {
        for (std::size_t i = 0; i < words.size(); ++i) {
            const std::string word(words[i]);
            if (ImGui::Selectable(word.c_str(), i == value)) {
                changed = i != value;
                value = i;
            }
            note(concat(name, "=", word), "", false);
        }
        ImGui::EndCombo();
    }
    changed_ = changed_ || changed;
    return changed;
}

bool ImguiControls::text(std::string_view name, std::string& value)
{
    (void)input_text(label(name), value);
    return note(name, value, ImGui::IsItemDeactivatedAfterEdit());
}

bool ImguiControls::button(std::string_view name)
{
    const bool pressed = ImGui::Button(std::string(name).c_str());
    return note(name, "", pressed);
}

} // namespace proxima
