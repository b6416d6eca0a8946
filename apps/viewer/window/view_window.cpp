#include "viewer/window/view_window.h"

#include "cli/image.h"
#include "proxima/base/text.h"
#include "viewer/gl_layers.h"
#include "viewer/gl_target.h"
#include "viewer/layers_glb.h"
#include "viewer/renderer.h"
#include "viewer/window/file_panel.h"
#include "viewer/window/glfw_window.h"
#include "viewer/window/sidebar.h"
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

/// What decides how the models' picture looks: drawn anew only where it differs.
struct DrawnPicture {
    std::vector<SceneLayer> layers;
    OrbitCamera camera;
    ViewSize size;
    Theme theme = Theme::light;
    int samples = 0;
};

bool same_camera(const OrbitCamera& a, const OrbitCamera& b)
{
    return a.target == b.target && a.distance == b.distance && a.azimuth == b.azimuth &&
           a.elevation == b.elevation && a.up == b.up && a.zoom == b.zoom && a.shift == b.shift;
}

bool same_layer(const SceneLayer& a, const SceneLayer& b)
{
    const auto same_color = [&] {
        return a.color.has_value() == b.color.has_value() &&
               (!a.color || (*a.color == *b.color).all());
    };
    const auto same_cut = [&] {
        return a.cut.has_value() == b.cut.has_value() &&
               (!a.cut || (a.cut->normal == b.cut->normal && a.cut->offset == b.cut->offset));
    };
    return a.scene == b.scene && a.pose.rotation == b.pose.rotation &&
           a.pose.translation == b.pose.translation && a.opacity == b.opacity && same_color() &&
           same_cut();
}

/// The same layers from the same place; samples may differ.
bool same_view(const DrawnPicture& a, const DrawnPicture& b)
{
    return a.size.width == b.size.width && a.size.height == b.size.height && a.theme == b.theme &&
           same_camera(a.camera, b.camera) && std::ranges::equal(a.layers, b.layers, same_layer);
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
    ViewWindow(GlfwWindow window, GlPainter painter, GlTarget target, Viewer& viewer,
               const WindowOptions& options)
        : window_(std::move(window)), painter_(std::move(painter)), target_(std::move(target)),
          viewer_(viewer), options_(options)
    {
        state_.scale = window_.scale();
        if (const auto* const name = glGetString(GL_RENDERER); name != nullptr)
            state_.renderer = reinterpret_cast<const char*>(name);
        const std::string& renderer = state_.renderer;
        draws_slowly_ = renderer.find("llvmpipe") != std::string::npos ||
                        renderer.find("softpipe") != std::string::npos;
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

    /// Menus need some frames to find their place.
    void redraw() noexcept { frames_wanted_ = 6; }

    [[nodiscard]] Vec2 in_view(const Vec2& at) const { return {at.x() - sidebar_width(), at.y()}; }

    /// Whether the mouse is over the picture and no menu hangs over it.
    [[nodiscard]] bool is_over_view() const
    {
        return mouse_.x() >= sidebar_width() && !files_.covers(mouse_) &&
               !ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
    }

    void on_button(int button, int action, int mods)
    {
        redraw();
        if (action == GLFW_RELEASE) {
            viewer_.release(in_view(mouse_));
            return;
        }
        if (!is_over_view()) return;
        const MouseButton pressed = button == GLFW_MOUSE_BUTTON_LEFT    ? MouseButton::left
                                    : button == GLFW_MOUSE_BUTTON_RIGHT ? MouseButton::right
                                                                        : MouseButton::middle;
        const Vec2 at = in_view(mouse_);
        constexpr double double_click_seconds = 0.35;
        const bool again = pressed == MouseButton::left &&
                           seconds_since(last_press_) < double_click_seconds &&
                           (at - last_press_at_).norm() < 5.0;
        last_press_ = Clock::now();
        last_press_at_ = at;
        if (again) {
            viewer_.double_click(at);
        } else {
            viewer_.press(pressed, at, (mods & GLFW_MOD_SHIFT) != 0);
        }
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
        if (frames_wanted_ > 0) {
            --frames_wanted_;
            glfwPollEvents();
        } else {
            glfwWaitEventsTimeout(viewer_.is_moving() || needs_refining_       ? frame
                                  : !viewer_.is_settled() || saving_.is_busy() ? watching
                                                                               : idle);
        }
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
        ImGui::NewFrame();
        apply_theme();
        std::vector<WidgetPlace> widgets;
        const SidebarWishes wishes =
            sidebar_.draw(viewer_, static_cast<float>(state_.view_x),
                          static_cast<float>(state_.height), news_, widgets);
        const std::string problem =
            viewer_.loading_error() ? describe(*viewer_.loading_error()) : std::string();
        const double margin = 12.0 * window_.scale();
        auto chosen =
            files_.draw(static_cast<float>(state_.view_x + margin), static_cast<float>(margin),
                        static_cast<float>(std::clamp(state_.view_width - 2.0 * margin, 1.0,
                                                      520.0 * window_.scale())),
                        static_cast<float>(
                            std::clamp(state_.height - 2.0 * margin, 1.0, 560.0 * window_.scale())),
                        problem, widgets);
        if (chosen) open({std::move(*chosen)});
        draw_handles();
        ImGui::Render();
        follow(wishes);

        const double ratio = static_cast<double>(pixels_wide) / state_.width;
        const int left = static_cast<int>(std::lround(ratio * state_.view_x));
        if (Status status = draw_models({std::max(1, pixels_wide - left), pixels_high}); !status)
            return status;
        target_.show(0, left, 0);
        glViewport(0, 0, pixels_wide, pixels_high);
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        glfwSwapBuffers(window_.get());
        ++state_.frames;
        return write_state(widgets);
    }

    /// Many samples a pixel where that is cheap, or once nothing moves any more.
    [[nodiscard]] Status draw_models(ViewSize size)
    {
        constexpr int fine = 4;
        DrawnPicture wanted = {viewer_.layers(), viewer_.camera(), size, viewer_.theme(), fine};
        const bool moves = !same_view(wanted, drawn_);
        if (moves) last_move_ = Clock::now();
        if (draws_slowly_) {
            constexpr double rest = 0.2;
            const bool is_still = !moves && seconds_since(last_move_) > rest;
            if (!is_still && !(drawn_.samples == fine && !moves)) wanted.samples = 1;
        }
        needs_refining_ = wanted.samples != fine && !viewer_.is_moving();
        if (!moves && wanted.samples == drawn_.samples) return {};
        const auto begin = Clock::now();
        if (Status status = gl_layers_.show(wanted.layers); !status) return status;
        if (Status status = target_.bind(size, wanted.samples); !status) return status;
        painter_.draw(gl_layers_.layers(), viewer_.backdrop(), wanted.camera, size);
        if (!options_.state.empty()) {
            glFinish();
            if (wanted.samples == 1 || !draws_slowly_) state_.frame_seconds = seconds_since(begin);
        }
        drawn_ = std::move(wanted);
        return {};
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

    /// Rings round places that can be dragged.
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
        if (wishes.forget_problem) viewer_.forget_problem();
        if (saving_.is_finished()) {
            const Status written = saving_.take();
            news_ = written ? concat("wrote ", saving_as_) : describe(written.error());
            redraw();
        }
        if (saving_.is_busy() || (wishes.picture.empty() && wishes.glb.empty())) return;
        saving_as_ = wishes.picture.empty() ? wishes.glb : wishes.picture;
        news_ = concat("writing ", saving_as_);
        saving_.start(
            [layers = viewer_.layers(), backdrop = viewer_.backdrop(), camera = viewer_.camera(),
             size = ViewSize{state_.view_width, state_.view_height}, path = saving_as_,
             is_picture = !wishes.picture.empty()](Progress& progress) -> Status {
                const Scene scene = flattened(layers, backdrop);
                if (!is_picture) return export_scene(scene, path, &progress);
                const auto image = make_software_renderer(&progress)->render(scene, camera, size);
                if (!image) return tl::unexpected(image.error());
                return write_png(*image, path, &progress);
            },
            wake_window);
    }

    [[nodiscard]] Status write_state(const std::vector<WidgetPlace>& widgets)
    {
        if (options_.state.empty()) return {};
        state_.files_open = files_.is_open();
        state_.uploads = gl_layers_.uploads();
        state_.uploaded_bytes = gl_layers_.uploaded_bytes();
        return write_window_state(options_.state, state_, viewer_, widgets);
    }

    // The window is destroyed last: the others need its context.
    GlfwWindow window_;
    GlPainter painter_;
    GlTarget target_;
    GlLayers gl_layers_;
    Viewer& viewer_;
    const WindowOptions& options_;
    Sidebar sidebar_;
    FilePanel files_{wake_window};
    bool awaits_models_ = false; ///< some are being loaded
    bool is_asked_for_ = false;  ///< by the command line
    WindowState state_;
    DrawnPicture drawn_;
    bool draws_slowly_ = false;
    bool needs_refining_ = false;
    int frames_wanted_ = 3;
    std::optional<Theme> styled_;
    Clock::time_point last_move_ = Clock::now();
    Vec2 mouse_ = Vec2::Zero();
    Clock::time_point last_press_;
    Vec2 last_press_at_ = Vec2::Zero();
    std::string news_;
    std::string saving_as_;
    BackgroundWork<Status> saving_;
};

} // namespace

Status run_window(Viewer& viewer, const WindowOptions& options)
{
    auto window = GlfwWindow::create("Proxima", options.size,
                                     options.debug ? ContextKind::debug : ContextKind::usual);
    if (!window) return tl::unexpected(window.error());
    auto painter = GlPainter::create();
    if (!painter) return tl::unexpected(painter.error());
    auto target = GlTarget::create();
    if (!target) return tl::unexpected(target.error());
    return ViewWindow(std::move(*window), std::move(*painter), std::move(*target), viewer, options)
        .run();
}

void wake_window()
{
    glfwPostEmptyEvent(); // reports an error to nobody where there is no window
}

} // namespace proxima
