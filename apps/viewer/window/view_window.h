// The window of `proxima view`: GLFW, Dear ImGui and OpenGL 3.3.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/viewer.h"

#include <string>
#include <vector>

namespace proxima {

struct WindowOptions {
    std::vector<std::string> models; ///< opened once there is a window; none: it asks for one
    ViewSize size = {.width = 1280, .height = 820}; ///< before the screen's scale
    std::string state;  ///< a file that says what the window shows, kept up to date; empty: none
    bool debug = false; ///< a debug context, whose messages count as problems
    const Progress* stop = nullptr; ///< closes the window when cancelled
};

/// Shows the viewer until the window is closed. The viewer's `wake` must be wake_window. Errors:
/// unsupported_format (no display, no OpenGL 3.3, a program without a window), those of the models
/// that are opened first, limit_exceeded (the graphics system has no memory left),
/// broken_invariant where OpenGL complains in debug.
[[nodiscard]] Status run_window(Viewer& viewer, const WindowOptions& options);

/// Makes a window that waits look again. From any thread; nothing without a window.
void wake_window();

} // namespace proxima
