#include "viewer/window/file_panel.h"

#include "base/text.h"
#include "cli/printable.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "viewer/window/input_text.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <imgui.h>
#include <system_error>
#include <utility>

namespace proxima {
namespace {

namespace fs = std::filesystem;

std::string size_of(std::uintmax_t bytes)
{
    constexpr std::array units = {"B", "kB", "MB", "GB", "TB"};
    auto size = static_cast<double>(bytes);
    std::size_t unit = 0;
    for (; size >= 1000.0 && unit + 1 < units.size(); ++unit) size /= 1000.0;
    const int decimals = size < 10.0 && unit > 0 ? 1 : 0;
    return fmt::format("{:.{}f} {}", size, decimals, units[unit]);
}

bool is_folder(const fs::path& path)
{
    std::error_code error;
    return fs::is_directory(path, error);
}

} // namespace

void FilePanel::open()
{
    if (!is_open_) is_typing_ = is_entered_ = false; // an Enter while it was closed is not meant
    is_open_ = true;
    wants_keys_ = true;
    std::error_code error;
    go_to(list_.folder.empty() ? fs::current_path(error) : list_.folder);
}

void FilePanel::go_to(const fs::path& folder)
{
    wanted_ = folder;
}

void FilePanel::follow_list()
{
    if (listing_.is_finished()) {
        auto listed = listing_.take();
        problem_ = listed ? std::string() : describe(listed.error());
        if (listed) list_ = std::move(*listed);
    }
    if (wanted_.empty() || listing_.is_busy()) return;
    listing_.start([folder = std::exchange(wanted_, {})](
                       Progress& progress) { return list_folder(folder, &progress); },
                   wake_);
}

std::optional<std::string> FilePanel::chosen(const std::string& typed)
{
    const fs::path path = typed_path(typed, list_.folder);
    if (path.empty()) return std::nullopt;
    if (is_sample_mesh_name(path.string())) return path.string(); // whatever files there are
    if (is_folder(path)) {
        go_to(path);
        path_.clear();
        return std::nullopt;
    }
    go_to(path.parent_path());
    return path.string();
}

std::optional<std::string> FilePanel::draw(float x, float y, float width, float height,
                                           std::vector<WidgetBounds>& widgets)
{
    if (!is_open_) return std::nullopt;
    follow_list();
    ImGui::SetNextWindowPos(ImVec2(x, y));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    ImGui::Begin("open a model", &is_open_,
                 ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoSavedSettings);
    lower_ = {x, y};
    upper_ = {x + width, y + height};
    std::optional<std::string> result;
    const float button = 5.0F * ImGui::GetFontSize();
    ImGui::SetNextItemWidth(-button);
    if (std::exchange(wants_keys_, false)) ImGui::SetKeyboardFocusHere();
    bool entered = input_text(
        "##path", path_, ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
    entered = std::exchange(is_entered_, false) || entered;
    is_typing_ = ImGui::IsItemActive();
    add_widget("path", path_, widgets);
    ImGui::SameLine();
    const bool pressed = ImGui::Button("open", ImVec2(-1.0F, 0.0F));
    add_widget("open", {}, widgets);
    if (entered || pressed) result = chosen(path_);
    ImGui::Checkbox("beside those there are", &beside_);
    add_widget("beside those there are", beside_ ? "on" : "off", widgets);
    wrapped(concat("A file (", known_mesh_extensions(),
                   "), a folder, or a built-in: ", sample_mesh_names()));
    ImGui::Separator();
    end_of_line(printable(list_.folder.string())); // the list stays where it is as folders change
    if (auto clicked = draw_list(-1.0F, widgets)) result = std::move(clicked);
    ImGui::End();
    return result;
}

std::optional<std::string> FilePanel::draw_list(float height, std::vector<WidgetBounds>& widgets)
{
    std::optional<std::string> result;
    ImGui::BeginChild("folder", ImVec2(0.0F, height), true);
    // A folder is entered by the first click: the second one of a double-click then meets whatever
    // has come to its position, which nobody has chosen.
    const auto is_clicked = [](const std::string& shown, bool is_chosen) {
        return ImGui::Selectable(shown.c_str(), is_chosen, ImGuiSelectableFlags_AllowDoubleClick) &&
               (is_chosen || !ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left));
    };
    const auto enter = [this](const fs::path& folder) {
        go_to(folder);
        path_.clear();
    };
    if (is_clicked("../", false)) enter(list_.folder.parent_path());
    add_widget("../", {}, widgets);
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(list_.entries.size()));
    while (clipper.Step()) {
        for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
            const FolderEntry& entry = list_.entries[static_cast<std::size_t>(i)];
            const std::string shown = entry.is_folder ? entry.name + '/' : entry.name;
            ImGui::PushID(i);
            if (is_clicked(shown, !entry.is_folder && path_ == entry.name)) {
                if (entry.is_folder) {
                    enter(list_.folder / entry.name);
                } else {
                    path_ = entry.name;
                    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left))
                        result = chosen(entry.name);
                }
            }
            add_widget(shown, {}, widgets);
            if (!entry.is_folder) {
                const std::string size = size_of(entry.bytes);
                ImGui::SameLine(ImGui::GetWindowContentRegionMax().x -
                                ImGui::CalcTextSize(size.c_str()).x);
                ImGui::TextUnformatted(size.c_str());
            }
            ImGui::PopID();
        }
    }
    if (!list_.is_whole) ImGui::TextUnformatted("and more: type a name");
    ImGui::EndChild();
    return result;
}

} // namespace proxima
