#include "viewer/window/glfw_window.h"

#include "base/text.h"

#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <cmath>
#include <filesystem>
#include <imgui.h>
#include <utility>

namespace proxima {
namespace {

/// GLFW's last words.
std::string reason()
{
    const char* words = nullptr;
    if (glfwGetError(&words) == GLFW_NO_ERROR || words == nullptr) return "no reason was given";
    return words;
}

tl::unexpected<Error> no_window(const std::string& what)
{
    return fail(
        ErrorCode::unsupported_format,
        concat(what, " (", reason(), "); --picture FILE.png makes a picture without a window"),
        "window");
}

/// A scalable font where one is installed: ImGui's own has one size.
void load_font(double scale)
{
    constexpr double points = 15.0;
    constexpr std::array files = {
        "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
        "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
        "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"};
    ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
    const auto size = static_cast<float>(std::round(points * scale));
    std::error_code error;
    for (const char* const file : files) {
        if (!std::filesystem::exists(file, error)) continue;
        if (atlas.AddFontFromFileTTF(file, size) != nullptr) return;
    }
    ImFontConfig config;
    config.SizePixels = static_cast<float>(std::round(13.0 * scale));
    atlas.AddFontDefault(&config);
}

} // namespace

Result<GlfwWindow> GlfwWindow::create(const char* title, ViewSize size, ContextKind kind)
{
    if (glfwInit() == GLFW_FALSE) return no_window("there is no display to open a window on");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, kind == ContextKind::debug ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    GLFWwindow* const window = glfwCreateWindow(size.width, size.height, title, nullptr, nullptr);
    if (window == nullptr) {
        auto error = no_window("there is no OpenGL 3.3 for a window here");
        glfwTerminate();
        return error;
    }
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    float across = 1.0F;
    float down = 1.0F;
    glfwGetWindowContentScale(window, &across, &down);
    return GlfwWindow(window, std::clamp(static_cast<double>(std::max(across, down)), 1.0, 4.0));
}

GlfwWindow::GlfwWindow(GlfwWindow&& other) noexcept
    : window_(std::exchange(other.window_, nullptr)), scale_(other.scale_),
      has_imgui_(std::exchange(other.has_imgui_, false))
{}

GlfwWindow::~GlfwWindow()
{
    if (window_ == nullptr) return;
    if (has_imgui_) {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    glfwDestroyWindow(window_);
    glfwTerminate();
}

void GlfwWindow::start_imgui()
{
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr; // nothing is remembered
    io.LogFilename = nullptr;
    load_font(scale_);
    ImGui::GetStyle().ScaleAllSizes(static_cast<float>(scale_));
    ImGui::GetStyle().WindowRounding = 0.0F;
    ImGui::GetStyle().FrameBorderSize = 1.0F; // boxes without a mark are seen on a light ground
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    has_imgui_ = true;
}

} // namespace proxima
