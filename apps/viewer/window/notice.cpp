#include "viewer/window/notice.h"

#include <algorithm>
#include <imgui.h>

namespace proxima {

bool Notice::draw(float x, float y, float width, float height, const std::string& problem,
                  const std::string& news, std::vector<WidgetBounds>& widgets)
{
    if (problem != hidden_) hidden_.clear();
    const bool has_problem = !problem.empty() && problem != hidden_;
    lower_ = upper_ = Vec2::Zero();
    if (!has_problem && news.empty()) return false;

    // As high as its words, beside the button.
    const ImGuiStyle& style = ImGui::GetStyle();
    constexpr const char* button = "hide this";
    const float button_width = ImGui::CalcTextSize(button).x + 2.0F * style.FramePadding.x;
    const float text_width =
        std::max(1.0F, width - 2.0F * style.WindowPadding.x - style.ItemSpacing.x - button_width);
    const auto high = [&](const std::string& text) {
        return ImGui::CalcTextSize(text.c_str(), nullptr, false, text_width).y +
               style.ItemSpacing.y;
    };
    const float text_height =
        (has_problem ? high(problem) : 0.0F) + (news.empty() ? 0.0F : high(news));
    const float shown = std::min(height, 2.0F * style.WindowPadding.y +
                                             std::max(text_height, ImGui::GetFrameHeight()));
    lower_ = {x, y - shown};
    upper_ = {x + width, y};
    ImGui::SetNextWindowPos(ImVec2(x, y - shown));
    ImGui::SetNextWindowSize(ImVec2(width, shown));
    ImGui::Begin("notice", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar |
                     ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::BeginChild("words", ImVec2(text_width, 0.0F));
    if (has_problem) wrapped_problem(problem);
    if (!news.empty()) wrapped(news);
    ImGui::EndChild();
    ImGui::SameLine();
    const bool is_hidden = ImGui::Button(button);
    if (is_hidden) hidden_ = problem;
    add_widget(button, {}, widgets);
    ImGui::End();
    return is_hidden;
}

} // namespace proxima
