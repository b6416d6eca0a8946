// What a window shows, as JSON in a file: for tests and for programs that drive the window by
// events. Where each control is, the facts, the work in progress, what was uploaded.
#pragma once

#include "proxima/result.h"
#include "viewer/viewer.h"
#include "viewer/window/imgui_controls.h"

#include <cstdint>
#include <string>

namespace proxima {

struct WindowState {
    std::uint64_t frames = 0;
    double frame_seconds = 0.0; ///< duration of the last frame that drew the models
    int width = 0;              ///< of the window
    int height = 0;
    int view_x = 0; ///< where the picture begins, in the window's coordinates
    int view_width = 0;
    int view_height = 0;
    double scale = 1.0;      ///< of the screen
    bool files_open = false; ///< the panel that opens models
    std::string problem;     ///< the message about a problem, also while it is hidden
    std::string news;        ///< of files that are written
    std::size_t uploads = 0;
    std::size_t uploaded_bytes = 0;
    std::uint64_t gl_messages = 0;
    std::string renderer; ///< OpenGL's
};

/// Writes the file. Readers never see a part of it. Error file_not_writable.
[[nodiscard]] Status write_window_state(const std::string& path, const WindowState& state,
                                        const Viewer& viewer,
                                        const std::vector<WidgetBounds>& widgets);

} // namespace proxima
