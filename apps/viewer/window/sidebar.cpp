#include "viewer/window/sidebar.h"

#include "base/text.h"
#include "viewer/window/input_text.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <imgui.h>
#include <utility>

namespace proxima {
namespace {

void draw_facts(const Viewer& viewer)
{
    if (viewer.facts().empty() || !ImGui::BeginTable("facts", 2)) return;
    ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthFixed);
    ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthStretch);
    for (const PanelFact& fact : viewer.facts()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(fact.name.c_str());
        ImGui::TableNextColumn();
        wrapped(fact.value);
    }
    ImGui::EndTable();
}

/// From zero, or what is below it, up to the largest value.
std::pair<float, float> range_of(const PanelPlot& plot)
{
    float least = 0.0F;
    float most = 0.0F;
    for (const float value : plot.values) {
        least = std::min(least, value);
        most = std::max(most, value);
    }
    return {least, most};
}

/// Counts as they are, others to four digits.
std::string words_for(float value)
{
    constexpr float exact = 1e7F;
    const bool is_count = value == std::round(value) && std::abs(value) < exact;
    return is_count ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}

void draw_plots(const Viewer& viewer)
{
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 5.0F * ImGui::GetTextLineHeight());
    for (const PanelPlot& plot : viewer.plots()) {
        const auto [least, most] = range_of(plot);
        wrapped(fmt::format("{}: {} to {}", plot.name, words_for(least), words_for(most)));
        const std::string id = concat("##", plot.name);
        const auto count = static_cast<int>(plot.values.size());
        const float top = most > least ? most : least + 1.0F;
        if (plot.bars) {
            ImGui::PlotHistogram(id.c_str(), plot.values.data(), count, 0, nullptr, least, top,
                                 size);
        } else {
            ImGui::PlotLines(id.c_str(), plot.values.data(), count, 0, nullptr, least, top, size);
        }
    }
}

/// A file's name and the button that writes it.
bool draw_file(const char* button, std::string& name, std::vector<WidgetBounds>& widgets)
{
    const bool pressed = ImGui::Button(button);
    add_widget(button, {}, widgets);
    ImGui::SameLine(0.42F * ImGui::GetWindowContentRegionMax().x);
    ImGui::SetNextItemWidth(-1.0F);
    (void)input_text(concat("##", button, " as"), name);
    add_widget(concat(button, " as"), name, widgets);
    return pressed && !name.empty();
}

/// What goes on.
void draw_work(const Viewer& viewer, SidebarWishes& wishes, std::vector<WidgetBounds>& widgets)
{
    if (ImGui::Button("open...")) wishes.open = true;
    add_widget("open...", {}, widgets);
    ImGui::SameLine();
    if (const auto progress = viewer.progress(); progress != nullptr) {
        if (ImGui::Button("cancel")) wishes.cancel = true;
        add_widget("cancel", {}, widgets);
        ImGui::SameLine();
        ImGui::ProgressBar(static_cast<float>(progress->fraction()), ImVec2(-1.0F, 0.0F),
                           progress->stage());
    } else {
        ImGui::AlignTextToFramePadding();
        ImGui::TextUnformatted(viewer.models().empty() ? "no model yet" : "ready");
    }
}

} // namespace

SidebarWishes Sidebar::draw(Viewer& viewer, float width, float height,
                            std::vector<WidgetBounds>& widgets)
{
    SidebarWishes wishes;
    ImGui::SetNextWindowPos(ImVec2(0.0F, 0.0F));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    // The bar is always there: coming and going it would make all controls wider and narrower.
    ImGui::Begin("proxima", nullptr,
                 ImGuiWindowFlags_AlwaysVerticalScrollbar | ImGuiWindowFlags_NoTitleBar |
                     ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    draw_work(viewer, wishes, widgets);
    ImGui::Separator();
    ImguiControls controls;
    viewer.offer(controls);
    widgets.insert(widgets.end(), controls.widgets().begin(), controls.widgets().end());
    ImGui::Separator();
    if (draw_file("save picture", picture_, widgets)) wishes.picture = picture_;
    if (draw_file("export glb", glb_, widgets)) wishes.glb = glb_;
    // Below all controls stands what grows and shrinks by itself.
    ImGui::Separator();
    ImVec4 quiet = ImGui::GetStyleColorVec4(ImGuiCol_Text);
    quiet.w = 0.75F;
    ImGui::PushStyleColor(ImGuiCol_Text, quiet);
    wrapped(viewer.panel().purpose());
    ImGui::PopStyleColor();
    ImGui::Separator();
    draw_facts(viewer);
    draw_plots(viewer);
    ImGui::End();
    return wishes;
}

} // namespace proxima
