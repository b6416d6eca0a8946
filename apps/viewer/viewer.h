// The viewer without its window: models, panels, the camera and what the mouse does, and work in
// the background. A window shows it, the command line makes one picture of it, tests do both.
//
//     Viewer viewer({.execution = {.threads = threads}});
//     viewer.open({"bunny.obj"});                       // returns at once
//     for (;;) {
//         viewer.update(seconds);
//         draw(viewer.layers(), viewer.camera());
//     }
#pragma once

#include "cli/camera_options.h"
#include "proxima/execution.h"
#include "proxima/mesh_io.h"
#include "proxima/result.h"
#include "viewer/background_work.h"
#include "viewer/controls.h"
#include "viewer/panel.h"

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace proxima {

enum class Theme : std::uint8_t { light, dark };

enum class MouseButton : std::uint8_t { left, middle, right };

/// What opened models do to the models that are shown.
enum class Placing : std::uint8_t {
    instead, ///< they replace them
    beside   ///< they are added to them
};

struct ViewerOptions {
    Pictures pictures = Pictures::still;
    std::function<void()> wake = {};               ///< called by the worker when a result is ready
    CameraChoice camera = {};                      ///< at first; its size does not matter
    Primitives primitives = Primitives::triangles; ///< that are read of files
    Execution execution = {}; ///< budget: of a model and of what is built of it
};

class Viewer {
public:
    explicit Viewer(ViewerOptions options = {});
    ~Viewer() = default;
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// Begins to load models, and cancels loading that is still running. The present models stay
    /// until all new ones are loaded. They also stay if one cannot be opened.
    void open(std::vector<std::string> names, Placing placing = Placing::instead);

    /// Takes finished results and starts new work. `seconds` is the time since the last update.
    void update(double seconds);

    // For pictures without a window; errors also where `stop` is cancelled.
    /// Updates until the models are there. Error: one could not be opened.
    [[nodiscard]] Status finish_loading(const Progress* stop = nullptr);
    /// Updates until there is nothing left to do. Errors: a model could not be opened, the panel could
    /// not do its task.
    [[nodiscard]] Status finish(const Progress* stop = nullptr);

    /// Settings of the view and of the panel at hand.
    void offer(Controls& controls);

    [[nodiscard]] Status choose_panel(std::string_view name);
    [[nodiscard]] const Panel& panel() const noexcept { return *panels_[panel_]; }
    [[nodiscard]] std::vector<std::string_view> panel_names() const;

    // What the background does.
    [[nodiscard]] bool is_loading() const noexcept { return loading_.is_busy(); }
    [[nodiscard]] bool is_busy() const noexcept { return is_loading() || working_.is_busy(); }
    [[nodiscard]] bool is_settled() const noexcept { return !is_busy() && shown_ == wanted_; }
    [[nodiscard]] std::shared_ptr<const Progress> progress() const noexcept;
    void cancel() noexcept;
    /// Cancels, and waits until nobody works any more. Finished work is thrown away.
    void stop();
    /// Why the models that were opened last are not there; none while they are loaded.
    [[nodiscard]] const std::optional<Error>& loading_error() const noexcept
    {
        return loading_error_;
    }
    /// A message about the first of these that failed: loading, the panel's last task, the panel's
    /// live part (add_live). Empty if none did.
    [[nodiscard]] std::string problem() const;
    /// Removes the message, since a person has read it.
    void forget_problem();

    // What is shown.
    [[nodiscard]] const ViewModels& models() const noexcept { return models_; }
    [[nodiscard]] const PanelPicture& picture() const noexcept { return picture_; }
    [[nodiscard]] const std::vector<SceneLayer>& layers() const noexcept { return layers_; }
    [[nodiscard]] const std::vector<PanelFact>& facts() const noexcept { return facts_; }
    [[nodiscard]] const std::vector<PanelPlot>& plots() const noexcept { return plots_; }
    [[nodiscard]] const Legend& legend() const noexcept { return picture_.legend; }
    [[nodiscard]] const OrbitCamera& camera() const noexcept { return camera_; }
    [[nodiscard]] Theme theme() const noexcept { return theme_; }
    [[nodiscard]] Backdrop backdrop() const noexcept;
    [[nodiscard]] std::vector<Vec3> handles() const;
    [[nodiscard]] const std::optional<PickedPoint>& picked() const noexcept { return picked_; }
    /// Whether the panel moves by itself, so that the next update changes the picture.
    [[nodiscard]] bool is_moving() const { return panels_[panel_]->is_moving(); }

    // The mouse, in pixels of the picture. The left button turns the view, the middle or right one
    // moves it, and the wheel zooms. A handle can be dragged; meanwhile the wheel moves it along
    // the line of sight. A click picks a point, a double click puts it into the middle.
    void resize(ViewSize size);
    void press(MouseButton button, const Vec2& at, bool with_shift = false);
    void move(const Vec2& at);
    void release(const Vec2& at);
    void double_click(const Vec2& at);
    void wheel(double steps);
    /// Moves the camera so that all that the panel shows fills the picture.
    void frame_all();

private:
    enum class Drag : std::uint8_t { none, orbit, pan, handle };

    /// Updates until it is done, once at least.
    template <class Done>
    Status update_until(const Done& is_done, const Progress* stop);
    void leave_for(std::size_t panel);
    void take_models();
    void take_picture();
    /// What the panel shows at first.
    [[nodiscard]] Box focus() const;
    /// Moves the camera there, again once the task has found it.
    void frame();
    void frame(const Box& box);
    /// The camera stays where somebody put it.
    void keep_camera();
    /// To the eye or target that was asked for, once.
    void place_camera();
    void start_task();
    void show();
    [[nodiscard]] Ray ray_at(const Vec2& at) const;
    [[nodiscard]] std::optional<std::size_t> handle_at(const Vec2& at) const;
    void click(const Vec2& at);

    ViewerOptions options_;
    std::vector<std::unique_ptr<Panel>> panels_;
    std::size_t panel_ = 0;
    ViewModels models_;
    PanelPicture picture_;
    std::vector<SceneLayer> layers_;
    std::vector<PanelFact> facts_;
    std::vector<PanelPlot> plots_;
    std::optional<Error> loading_error_;
    std::string problem_;      ///< of the last task
    std::string live_problem_; ///< of this moment

    std::uint64_t wanted_ = 0; ///< version of the present settings
    std::uint64_t shown_ = 0;  ///< version of the settings that the picture shows
    std::uint64_t started_ = 0;
    std::chrono::steady_clock::time_point start_time_;

    OrbitCamera camera_;
    bool camera_is_set_ = false;
    bool awaits_focus_ = false; ///< the next picture of the present settings may say what to show
    ViewSize size_ = {.width = 1024, .height = 768};
    Theme theme_ = Theme::light;

    Drag drag_ = Drag::none;
    std::size_t handle_ = 0;
    Vec2 pressed_at_ = Vec2::Zero();
    Vec2 mouse_ = Vec2::Zero();
    bool moved_ = false;
    std::optional<PickedPoint> picked_;

    // Destroyed first: their threads use what is above.
    BackgroundWork<Result<ViewModels>> loading_;
    BackgroundWork<Result<PanelPicture>> working_;
};

} // namespace proxima
