#include "viewer/window/legend_box.h"

#include "base/text.h"

#include <imgui.h>

namespace proxima {

void draw_legend_box(const Legend& legend, float right, float top,
                     std::vector<WidgetBounds>& widgets)
{
    if (legend.entries.empty()) return;
    ImGui::SetNextWindowPos(ImVec2(right, top), ImGuiCond_Always, ImVec2(1.0F, 0.0F));
    ImGui::SetNextWindowBgAlpha(0.82F);
    // The mouse reaches the picture through it.
    ImGui::Begin("legend", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                     ImGuiWindowFlags_NoBringToFrontOnFocus);
    if (!legend.title.empty()) ImGui::TextUnformatted(legend.title.c_str());
    const float size = ImGui::GetTextLineHeight();
    for (const LegendEntry& entry : legend.entries) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const auto part = [&](unsigned shift) {
            return static_cast<int>(entry.color >> shift & 0xFFU);
        };
        ImGui::GetWindowDrawList()->AddRectFilled(at, ImVec2(at.x + size, at.y + size),
                                                  IM_COL32(part(16), part(8), part(0), 255));
        ImGui::Dummy(ImVec2(size, size));
        ImGui::SameLine();
        ImGui::TextUnformatted(entry.text.c_str());
        // In its first frame the box is hidden and not yet in its place.
        if (!ImGui::IsWindowAppearing()) add_widget(concat("legend ", entry.text), {}, widgets);
    }
    ImGui::End();
}

} // namespace proxima
