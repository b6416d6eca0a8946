// A window with an OpenGL 3.3 context and Dear ImGui in it, as an owner.
#pragma once

#include "cli/camera.h"
#include "proxima/result.h"

struct GLFWwindow;

namespace proxima {

enum class ContextKind : bool { usual, debug };

/// One at a time, by the main thread.
class GlfwWindow {
public:
    /// Its context is current, vertical synchronisation on. Size before the screen's scale. Error
    /// unsupported_format: no display, no OpenGL 3.3.
    [[nodiscard]] static Result<GlfwWindow> create(const char* title, ViewSize size,
                                                   ContextKind kind);

    GlfwWindow(GlfwWindow&& other) noexcept;
    GlfwWindow& operator=(GlfwWindow&&) = delete;
    GlfwWindow(const GlfwWindow&) = delete;
    GlfwWindow& operator=(const GlfwWindow&) = delete;
    ~GlfwWindow();

    [[nodiscard]] GLFWwindow* get() const noexcept { return window_; }

    /// Of text and widgets: 1 on usual screens, 2 on fine ones.
    [[nodiscard]] double scale() const noexcept { return scale_; }

    /// Starts ImGui, which calls the callbacks that were set before as well.
    void start_imgui();

private:
    GlfwWindow(GLFWwindow* window, double scale) noexcept : window_(window), scale_(scale) {}

    GLFWwindow* window_;
    double scale_;
    bool has_imgui_ = false;
};

} // namespace proxima
