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
    /// Lists this folder from now on: of a model that was opened, or one that was dropped.
    void go_to(const std::filesystem::path& folder);

    /// Reports the Enter key, which ImGui misses if it is released within a frame.
    void enter() noexcept { is_entered_ = is_typing_; }

    [[nodiscard]] Placing placing() const noexcept
    {
        return beside_ ? Placing::beside : Placing::instead;
    }

    /// Why the wanted folder could not be listed; empty if it was, or if the panel is closed.
    [[nodiscard]] std::string problem() const { return is_open_ ? problem_ : std::string(); }
    void forget_problem() { problem_.clear(); }

    /// Draws within a frame of ImGui, from (x, y) on, and adds the bounds of its widgets to `widgets`.
    /// May be called while it is closed. Returns the path of what is to be opened, if anything.
    [[nodiscard]] std::optional<std::string> draw(float x, float y, float width, float height,
                                                  std::vector<WidgetBounds>& widgets);

    /// Whether it lies over a point of the window.
    [[nodiscard]] bool covers(const Vec2& at) const noexcept
    {
        return is_open_ && (at.array() >= lower_.array()).all() &&
               (at.array() < upper_.array()).all();
    }

private:
    void follow_list();
    [[nodiscard]] std::optional<std::string> chosen(const std::string& typed);
    [[nodiscard]] std::optional<std::string> draw_list(float height,
                                                       std::vector<WidgetBounds>& widgets);

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
