#include "viewer/window/view_window.h"

#include "base/progress.h"
#include "base/text.h"
#include "viewer/window/file_panel.h"
#include "viewer/window/glfw_window.h"
#include "viewer/window/imgui_mouse.h"
#include "viewer/window/legend_box.h"
#include "viewer/window/mouse_presses.h"
#include "viewer/window/notice.h"
#include "viewer/window/sidebar.h"
#include "viewer/window/view_files.h"
#include "viewer/window/view_picture.h"
#include "viewer/window/window_state.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <chrono>
#include <cmath>
#include <epoxy/gl.h>
#include <filesystem>
#include <imgui.h>
#include <string_view>
#include <system_error>
#include <utility>

namespace proxima {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin)
{
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

void count_message(GLenum /*source*/, GLenum type, GLuint /*id*/, GLenum severity,
                   GLsizei /*length*/, const GLchar* /*message*/, const void* count)
{
    if (type != GL_DEBUG_TYPE_ERROR && severity != GL_DEBUG_SEVERITY_HIGH) return;
    // OpenGL hands the pointer back as it was given.
    ++*static_cast<std::uint64_t*>(const_cast<void*>(count));
}

class ViewWindow {
public:
    ViewWindow(GlfwWindow window, ViewPicture picture, std::string renderer, Viewer& viewer,
               const WindowOptions& options)
        : window_(std::move(window)), picture_(std::move(picture)), viewer_(viewer),
          options_(options)
    {
        state_.scale = window_.scale();
        state_.renderer = std::move(renderer);
        if (!options.state.empty()) picture_.measure();
        if (options.debug && epoxy_has_gl_extension("GL_KHR_debug")) {
            glEnable(GL_DEBUG_OUTPUT);
            glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
            glDebugMessageCallback(count_message, &state_.gl_messages);
        }
        set_callbacks();
        window_.start_imgui();
    }
    ViewWindow(const ViewWindow&) = delete;
    ViewWindow& operator=(const ViewWindow&) = delete;
    ~ViewWindow() { viewer_.stop(); } // workers wake the window: they end before it

    [[nodiscard]] Status run()
    {
        if (options_.models.empty()) {
            files_.open();
        } else {
            viewer_.open(options_.models);
            is_asked_for_ = awaits_models_ = true;
        }
        auto last = Clock::now();
        while (glfwWindowShouldClose(window_.get()) == GLFW_FALSE) {
            wait();
            if (is_cancelled(options_.stop))
                return fail(ErrorCode::cancelled, "the window was closed on request");
            const double passed = seconds_since(last);
            last = Clock::now();
            viewer_.update(passed);
            if (Status status = follow_loading(); !status) return status;
            if (Status status = draw_frame(); !status) return status;
        }
        glfwHideWindow(window_.get()); // a file that is being written is finished
        if (Status status = written_.finish(); !status) return status;
        if (state_.gl_messages > 0) {
            return fail(ErrorCode::broken_invariant,
                        concat("OpenGL reported ", state_.gl_messages, " errors"), "OpenGL");
        }
        return {};
    }

private:
    /// Error: the command's own models could not be opened. Others are opened by somebody who
    /// looks, and goes on.
    [[nodiscard]] Status follow_loading()
    {
        if (!awaits_models_ || viewer_.is_loading()) return {};
        awaits_models_ = false;
        const auto& error = viewer_.loading_error();
        if (!error) {
            files_.close();
        } else if (is_asked_for_ && error->code != ErrorCode::cancelled) {
            return tl::unexpected(*error);
        }
        redraw();
        return {};
    }

    void open(std::vector<std::string> paths)
    {
        is_asked_for_ = false;
        awaits_models_ = true;
        viewer_.open(std::move(paths), files_.placing());
        redraw();
    }

    // Callbacks find the window by GLFW's pointer; ImGui's, set later, call these too.
    void set_callbacks()
    {
        GLFWwindow* const window = window_.get();
        glfwSetWindowUserPointer(window, this);
        glfwSetMouseButtonCallback(window, [](GLFWwindow* from, int button, int action, int mods) {
            of(from).on_button(button, action, mods);
        });
        glfwSetCursorPosCallback(window, [](GLFWwindow* from, double x, double y) {
            of(from).on_move({x, y});
        });
        glfwSetScrollCallback(
            window, [](GLFWwindow* from, double /*x*/, double y) { of(from).on_wheel(y); });
        glfwSetKeyCallback(window, [](GLFWwindow* from, int key, int /*code*/, int action, int) {
            if (action == GLFW_PRESS) of(from).on_key(key);
        });
        glfwSetDropCallback(window, [](GLFWwindow* from, int count, const char** paths) {
            of(from).on_drop({paths, paths + count});
        });
        glfwSetWindowRefreshCallback(window, [](GLFWwindow* from) { of(from).redraw(); });
    }

    static ViewWindow& of(GLFWwindow* window)
    {
        return *static_cast<ViewWindow*>(glfwGetWindowUserPointer(window));
    }

    /// Menus need some frames to find their position.
    void redraw() noexcept { frames_wanted_ = 6; }

    [[nodiscard]] Vec2 in_view(const Vec2& at) const { return {at.x() - sidebar_width(), at.y()}; }

    /// Whether the mouse is over the picture and no menu hangs over it.
    [[nodiscard]] bool is_over_view() const
    {
        return mouse_.x() >= sidebar_width() && !files_.covers(mouse_) && !notice_.covers(mouse_) &&
               !ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
    }

    void on_button(int button, int action, int mods)
    {
        redraw();
        imgui_mouse_.add(button, action != GLFW_RELEASE, mouse_, Clock::now(), deaf_);
        if (action == GLFW_RELEASE) {
            presses_.release(viewer_, in_view(mouse_));
            return;
        }
        if (is_over_view()) presses_.press(viewer_, button, mods, in_view(mouse_));
    }

    void on_move(const Vec2& at)
    {
        redraw();
        mouse_ = at;
        viewer_.move(in_view(at));
    }

    void on_wheel(double steps)
    {
        redraw();
        if (is_over_view()) viewer_.wheel(steps);
    }

    void on_key(int key)
    {
        redraw();
        const bool with_control = glfwGetKey(window_.get(), GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS ||
                                  glfwGetKey(window_.get(), GLFW_KEY_RIGHT_CONTROL) == GLFW_PRESS;
        if (key == GLFW_KEY_O && with_control) files_.open();
        if (key == GLFW_KEY_ENTER || key == GLFW_KEY_KP_ENTER) files_.enter();
        if (key == GLFW_KEY_ESCAPE) {
            if (viewer_.is_busy()) {
                viewer_.cancel();
            } else {
                files_.close();
            }
        }
        if (ImGui::GetIO().WantTextInput) return;
        if (key == GLFW_KEY_F || key == GLFW_KEY_HOME) viewer_.frame_all();
        if (key == GLFW_KEY_Q) glfwSetWindowShouldClose(window_.get(), GLFW_TRUE);
    }

    void on_drop(std::vector<std::string> paths)
    {
        std::error_code unknown;
        if (paths.size() == 1 && std::filesystem::is_directory(paths.front(), unknown)) {
            files_.open();
            files_.go_to(paths.front());
            redraw();
        } else if (!paths.empty()) {
            open(std::move(paths));
        }
    }

    [[nodiscard]] double sidebar_width() const
    {
        return std::min(std::round(340.0 * window_.scale()), 0.6 * state_.width);
    }

    void wait()
    {
        constexpr double frame = 1.0 / 60.0;
        constexpr double watching = 0.1;
        constexpr double idle = 0.5;
        deaf_ = Clock::now() - heard_;
        if (frames_wanted_ > 0) {
            --frames_wanted_;
            glfwPollEvents();
        } else {
            glfwWaitEventsTimeout(viewer_.is_moving() || picture_.needs_refining() ? frame
                                  : !viewer_.is_settled() || written_.is_busy()    ? watching
                                                                                   : idle);
        }
        heard_ = Clock::now();
        frames_wanted_ = std::max(frames_wanted_, 0);
    }

    [[nodiscard]] Status draw_frame()
    {
        int pixels_wide = 0;
        int pixels_high = 0;
        glfwGetWindowSize(window_.get(), &state_.width, &state_.height);
        glfwGetFramebufferSize(window_.get(), &pixels_wide, &pixels_high);
        if (state_.width <= 0 || state_.height <= 0) return {}; // as small as an icon
        state_.view_x = static_cast<int>(sidebar_width());
        state_.view_width = std::max(1, state_.width - state_.view_x);
        state_.view_height = state_.height;
        viewer_.resize({state_.view_width, state_.view_height});

        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        imgui_mouse_.set(ImGui::GetIO());
        if (imgui_mouse_.has_more()) redraw();
        ImGui::NewFrame();
        apply_theme();
        std::vector<WidgetBounds> widgets;
        follow(sidebar_.draw(viewer_, static_cast<float>(state_.view_x),
                             static_cast<float>(state_.height), widgets));
        const double margin = 12.0 * window_.scale();
        draw_legend_box(viewer_.legend(), static_cast<float>(state_.width - margin),
                        static_cast<float>(margin), widgets);
        draw_over_picture(widgets);
        draw_handles();
        ImGui::Render();

        const double ratio = static_cast<double>(pixels_wide) / state_.width;
        const int left = static_cast<int>(std::lround(ratio * state_.view_x));
        const ViewSize size = {std::max(1, pixels_wide - left), pixels_high};
        if (Status status = picture_.draw(viewer_, size); !status) return status;
        picture_.show(left);
        glViewport(0, 0, pixels_wide, pixels_high);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        glfwSwapBuffers(window_.get());
        ++state_.frames;
        return write_state(widgets);
    }

    /// The panel that opens models, and below it the messages.
    void draw_over_picture(std::vector<WidgetBounds>& widgets)
    {
        const double margin = 12.0 * window_.scale();
        const double width = std::max(1.0, state_.view_width - 2.0 * margin);
        const double words = std::min(110.0 * window_.scale(), 0.3 * state_.height);
        const double list =
            std::clamp(state_.height - words - 3.0 * margin, 1.0, 560.0 * window_.scale());
        const auto left = static_cast<float>(state_.view_x + margin);
        auto chosen = files_.draw(left, static_cast<float>(margin),
                                  static_cast<float>(std::min(width, 520.0 * window_.scale())),
                                  static_cast<float>(list), widgets);
        if (chosen) open({std::move(*chosen)});
        if (notice_.draw(left, static_cast<float>(state_.height - margin),
                         static_cast<float>(std::min(width, 720.0 * window_.scale())),
                         static_cast<float>(words), problem(), written_.news(), widgets)) {
            forget();
        }
    }

    /// What was shown, and nothing that stands behind it.
    void forget()
    {
        if (!viewer_.problem().empty()) {
            viewer_.forget_problem();
        } else if (!files_.problem().empty()) {
            files_.forget_problem();
        } else {
            written_.forget_news();
        }
    }

    /// The first that somebody has to know of.
    [[nodiscard]] std::string problem() const
    {
        if (std::string words = viewer_.problem(); !words.empty()) return words;
        if (std::string words = files_.problem(); !words.empty()) return words;
        return written_.problem();
    }

    void apply_theme()
    {
        if (styled_ == viewer_.theme()) return;
        styled_ = viewer_.theme();
        if (styled_ == Theme::light) {
            ImGui::StyleColorsLight();
        } else {
            ImGui::StyleColorsDark();
        }
    }

    /// Rings round points that can be dragged.
    void draw_handles() const
    {
        const View view(viewer_.camera(), {state_.view_width, state_.view_height});
        ImDrawList& list = *ImGui::GetBackgroundDrawList();
        const auto radius = static_cast<float>(9.0 * window_.scale());
        for (const Vec3& handle : viewer_.handles()) {
            if (view.depth(handle) <= 0.0) continue;
            const ScreenPoint at = view.project(handle);
            const ImVec2 center(static_cast<float>(state_.view_x + at.x), static_cast<float>(at.y));
            if (center.x < static_cast<float>(state_.view_x)) continue;
            list.AddCircle(center, radius, IM_COL32(255, 255, 255, 220), 0, 4.0F);
            list.AddCircle(center, radius, IM_COL32(40, 90, 200, 255), 0, 2.0F);
        }
    }

    void follow(const SidebarWishes& wishes)
    {
        if (wishes.open) files_.open();
        if (wishes.cancel) viewer_.cancel();
        if (!wishes.picture.empty()) {
            written_.write_picture(viewer_, {state_.view_width, state_.view_height},
                                   wishes.picture);
        } else if (!wishes.glb.empty()) {
            written_.write_model(viewer_, wishes.glb);
        }
        if (written_.follow()) redraw();
    }

    [[nodiscard]] Status write_state(const std::vector<WidgetBounds>& widgets)
    {
        if (options_.state.empty()) return {};
        state_.files_open = files_.is_open();
        state_.problem = problem();
        state_.news = written_.news();
        state_.frame_seconds = picture_.frame_seconds();
        state_.uploads = picture_.uploads();
        state_.uploaded_bytes = picture_.uploaded_bytes();
        return write_window_state(options_.state, state_, viewer_, widgets);
    }

    // The window is destroyed last: the others need its context.
    GlfwWindow window_;
    ViewPicture picture_;
    Viewer& viewer_;
    const WindowOptions& options_;
    Sidebar sidebar_;
    FilePanel files_{wake_window};
    ViewFiles written_{wake_window};
    Notice notice_;
    bool awaits_models_ = false; ///< some are being loaded
    bool is_asked_for_ = false;  ///< by the command line
    WindowState state_;
    int frames_wanted_ = 3;
    std::optional<Theme> styled_;
    Vec2 mouse_ = Vec2::Zero();
    MousePresses presses_;
    ImguiMouse imgui_mouse_;
    Clock::time_point heard_ = Clock::now(); ///< when the last look at events ended
    ImguiMouse::Seconds deaf_{0.0};          ///< between the last two looks at events
};

} // namespace

Status run_window(Viewer& viewer, const WindowOptions& options)
{
    auto window = GlfwWindow::create("Proxima", options.size,
                                     options.debug ? ContextKind::debug : ContextKind::usual);
    if (!window) return tl::unexpected(window.error());
    std::string renderer;
    if (const auto* const name = glGetString(GL_RENDERER); name != nullptr)
        renderer = reinterpret_cast<const char*>(name);
    auto picture = ViewPicture::create(renderer);
    if (!picture) return tl::unexpected(picture.error());
    return ViewWindow(std::move(*window), std::move(*picture), std::move(renderer), viewer, options)
        .run();
}

void wake_window()
{
    glfwPostEmptyEvent(); // reports an error to nobody where there is no window
}

} // namespace proxima
