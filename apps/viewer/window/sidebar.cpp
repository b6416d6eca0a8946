#include "viewer/window/sidebar.h"

#include "proxima/base/text.h"
#include "viewer/window/input_text.h"

#include <imgui.h>

namespace proxima {
namespace {

void draw_facts(const Viewer& viewer)
{
    if (viewer.facts().empty() || !ImGui::BeginTable("facts", 2)) return;
    for (const PanelFact& fact : viewer.facts()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(fact.name.c_str());
        ImGui::TableNextColumn();
        wrapped(fact.value);
    }
    ImGui::EndTable();
}

void draw_plots(const Viewer& viewer)
{
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 5.0F * ImGui::GetTextLineHeight());
    for (const PanelPlot& plot : viewer.plots()) {
        ImGui::TextUnformatted(plot.name.c_str());
        const std::string id = concat("##", plot.name);
        const auto count = static_cast<int>(plot.values.size());
        constexpr float automatic = std::numeric_limits<float>::max();
        if (plot.bars) {
            ImGui::PlotHistogram(id.c_str(), plot.values.data(), count, 0, nullptr, 0.0F, automatic,
                                 size);
        } else {
            ImGui::PlotLines(id.c_str(), plot.values.data(), count, 0, nullptr, automatic,
                             automatic, size);
        }
    }
}

/// A file's name and the button that writes it.
bool draw_file(const char* button, std::string& name, std::vector<WidgetPlace>& places)
{
    const bool pressed = ImGui::Button(button);
    add_place(button, {}, places);
    ImGui::SameLine(0.42F * ImGui::GetWindowContentRegionMax().x);
    ImGui::SetNextItemWidth(-1.0F);
    (void)input_text(concat("##", button, " as"), name);
    add_place(concat(button, " as"), name, places);
    return pressed && !name.empty();
}

/// What goes on.
void draw_work(const Viewer& viewer, SidebarWishes& wishes, std::vector<WidgetPlace>& places)
{
    if (ImGui::Button("open...")) wishes.open = true;
    add_place("open...", {}, places);
    ImGui::SameLine();
    if (const Progress* const progress = viewer.progress(); progress != nullptr) {
        if (ImGui::Button("cancel")) wishes.cancel = true;
        add_place("cancel", {}, places);
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
                            std::vector<WidgetPlace>& places)
{
    SidebarWishes wishes;
    ImGui::SetNextWindowPos(ImVec2(0.0F, 0.0F));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    ImGui::Begin("proxima", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
    draw_work(viewer, wishes, places);
    ImGui::Separator();
    ImguiControls controls;
    viewer.offer(controls);
    places.insert(places.end(), controls.places().begin(), controls.places().end());
    ImGui::Separator();
    if (draw_file("save picture", picture_, places)) wishes.picture = picture_;
    if (draw_file("export glb", glb_, places)) wishes.glb = glb_;
    // Below all controls stands what grows and shrinks by itself.
    ImGui::Separator();
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    wrapped(viewer.panel().purpose());
    ImGui::PopStyleColor();
    ImGui::Separator();
    draw_facts(viewer);
    draw_plots(viewer);
    ImGui::End();
    return wishes;
}

} // namespace proxima
