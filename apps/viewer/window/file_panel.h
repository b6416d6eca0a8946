// Opening models from within the window: a path, and a list of what its folder offers.
//
//     path  [ /usr/share/glmark2/models/bunny.obj ] [open]
//     [ ] beside those there are
//       ../
//       textures/
//       bunny.obj          5.3 MB
#pragma once

#include "viewer/background_work.h"
#include "viewer/folder_list.h"
#include "viewer/viewer.h"
#include "viewer/window/imgui_controls.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace proxima {

class FilePanel {
public:
    /// `wake` is called by a thread that has listed a folder.
    explicit FilePanel(std::function<void()> wake) : wake_(std::move(wake)) {}

    [[nodiscard]] bool is_open() const noexcept { return is_open_; }
    void open();
    void close() noexcept { is_open_ = false; }
    /// Where a model that was opened lies, or a folder that was dropped: the list's from now on.
    void go_to(const std::filesystem::path& folder);

    /// The key was pressed: ImGui misses it where it is let go of within a frame.
    void enter() noexcept { is_entered_ = is_typing_; }

    [[nodiscard]] Placing placing() const noexcept
    {
        return beside_ ? Placing::beside : Placing::instead;
    }

    /// Why the folder wanted last is not listed, in words; empty if it is, and in a closed panel.
    [[nodiscard]] std::string problem() const { return is_open_ ? problem_ : std::string(); }
    void forget_problem() { problem_.clear(); }

    /// Within a frame of ImGui, from (x, y) on, closed or not; places of widgets are added. What is
    /// to be opened, if anything.
    [[nodiscard]] std::optional<std::string> draw(float x, float y, float width, float height,
                                                  std::vector<WidgetPlace>& places);

    /// Whether it lies over a place of the window.
    [[nodiscard]] bool covers(const Vec2& at) const noexcept
    {
        return is_open_ && (at.array() >= lower_.array()).all() &&
               (at.array() < upper_.array()).all();
    }

private:
    void follow_list();
    [[nodiscard]] std::optional<std::string> chosen(const std::string& typed);
    [[nodiscard]] std::optional<std::string> draw_list(float height,
                                                       std::vector<WidgetPlace>& places);

    std::function<void()> wake_;
    bool is_open_ = false;
    bool beside_ = false;
    bool wants_keys_ = false; ///< the path's field gets the keyboard
    bool is_typing_ = false;  ///< it has it
    bool is_entered_ = false;
    std::string path_;
    FolderList list_;
    std::string problem_; ///< of the folder
    std::filesystem::path wanted_;
    BackgroundWork<Result<FolderList>> listing_;
    Vec2 lower_ = Vec2::Zero();
    Vec2 upper_ = Vec2::Zero();
};

} // namespace proxima
