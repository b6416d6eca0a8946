#include "viewer/viewer.h"

#include "base/progress.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace proxima {
namespace {

/// Notes whether anything was changed, while another one asks.
class WatchedControls final : public Controls {
public:
    explicit WatchedControls(Controls& asked) : asked_(asked) {}

    bool toggle(std::string_view name, bool& value) override
    {
        return note(asked_.toggle(name, value));
    }
    bool number(std::string_view name, int& value, int least, int most) override
    {
        return note(asked_.number(name, value, least, most));
    }
    bool number(std::string_view name, double& value, double least, double most) override
    {
        return note(asked_.number(name, value, least, most));
    }
    bool choice(std::string_view name, std::size_t& value,
                std::span<const std::string_view> words) override
    {
        return note(asked_.choice(name, value, words));
    }
    bool text(std::string_view name, std::string& value) override
    {
        return note(asked_.text(name, value));
    }
    bool button(std::string_view name) override { return note(asked_.button(name)); }
    void begin_condition(std::string_view words, bool is_met) override
    {
        asked_.begin_condition(words, is_met);
    }
    void end_condition() override { asked_.end_condition(); }

    [[nodiscard]] bool changed() const noexcept { return changed_; }

private:
    bool note(bool changed)
    {
        changed_ = changed_ || changed;
        return changed;
    }

    Controls& asked_;
    bool changed_ = false;
};

bool same(const Box& a, const Box& b)
{
    return a.lower == b.lower && a.upper == b.upper;
}

/// The vertices that triangles of any model use.
std::vector<Vec3> points_to_frame(const ViewModels& models)
{
    std::vector<Vec3> positions;
    for (const auto& model : models) {
        const std::vector<Vec3> used = points_to_frame(model->mesh);
        positions.insert(positions.end(), used.begin(), used.end());
    }
    return positions;
}

} // namespace

Viewer::Viewer(ViewerOptions options)
    : options_(std::move(options)), panels_(make_panels(options_.pictures)),
      camera_(directed_camera(options_.camera))
{}

void Viewer::open(std::vector<std::string> names, Placing placing)
{
    if (loading_.is_busy()) {
        loading_.cancel();
        (void)loading_.take();
    }
    loading_error_.reset();
    ViewModels kept = placing == Placing::beside ? models_ : ViewModels{};
    loading_.start(
        [names = std::move(names), kept = std::move(kept), primitives = options_.primitives,
         up = options_.camera.up, threads = options_.execution.threads,
         budget = options_.execution.budget](Progress& progress) {
            return load_view_models(names, primitives, {threads, &progress, budget}, kept, up);
        },
        options_.wake);
}

void Viewer::take_models()
{
    auto models = loading_.take();
    if (!models) {
        // Whatever is shown stays.
        loading_error_ = std::move(models.error());
        if (loading_error_->code == ErrorCode::cancelled)
            loading_error_->message = "loading was stopped on request";
        return;
    }
    if (working_.is_busy()) {
        working_.cancel();
        (void)working_.take();
    }
    models_ = std::move(*models);
    picked_.reset();
    camera_.up = models_.front()->up;
    place_camera();
    const View view(camera_, size_);
    for (const auto& panel : panels_) panel->models_changed(models_, view.back());
    picture_ = {.layers = model_layers(models_, Smoothing::smooth), .facts = {}, .plots = {}};
    ++wanted_;
    if (!camera_is_set_) frame();
}

void Viewer::take_picture()
{
    auto picture = working_.take();
    shown_ = started_;
    if (picture) {
        picture_ = std::move(*picture);
        problem_.clear();
        if (started_ != wanted_) {
            picture_.focus.reset();
        } else {
            if (awaits_focus_ && picture_.focus) frame();
            awaits_focus_ = false;
        }
    } else {
        problem_ = picture.error().code == ErrorCode::cancelled
                       ? "stopped on request: change a setting to begin again"
                       : describe(picture.error());
        // Work that nobody wants any more is no problem.
        if (started_ != wanted_ && picture.error().code == ErrorCode::cancelled) problem_.clear();
    }
}

void Viewer::start_task()
{
    started_ = wanted_;
    start_time_ = std::chrono::steady_clock::now();
    working_.start(
        [task = panels_[panel_]->task(models_), threads = options_.execution.threads,
         budget = options_.execution.budget](Progress& progress) {
            return task({threads, &progress, budget});
        },
        options_.wake);
}

void Viewer::update(double seconds)
{
    if (loading_.is_finished()) take_models();
    if (working_.is_finished()) take_picture();
    if (models_.empty()) return;
    if (panels_[panel_]->advance(seconds)) ++wanted_;
    if (working_.is_busy()) {
        // What a moment takes is finished even when it is outdated, so that the picture follows the
        // mouse; longer work is not.
        constexpr std::chrono::milliseconds patience(250);
        if (started_ != wanted_ && std::chrono::steady_clock::now() - start_time_ > patience)
            working_.cancel();
    } else if (shown_ != wanted_) {
        start_task();
    }
    show();
}

void Viewer::show()
{
    PanelPicture live;
    panels_[panel_]->add_live(live);
    live_problem_ = std::move(live.problem);
    layers_ = picture_.layers;
    layers_.insert(layers_.end(), live.layers.begin(), live.layers.end());
    facts_ = picture_.facts;
    facts_.insert(facts_.end(), live.facts.begin(), live.facts.end());
    plots_ = picture_.plots;
    plots_.insert(plots_.end(), live.plots.begin(), live.plots.end());
}

template <class Done>
Status Viewer::update_until(const Done& is_done, const Progress* stop)
{
    do {
        update(0.0);
        if (is_cancelled(stop)) {
            cancel();
            return fail(ErrorCode::cancelled, "stopped on request; nothing was written");
        }
        if (loading_error_) return tl::unexpected(*loading_error_);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    } while (!is_done());
    return {};
}

Status Viewer::finish_loading(const Progress* stop)
{
    return update_until([&] { return !is_loading(); }, stop);
}

Status Viewer::finish(const Progress* stop)
{
    if (Status status = update_until([&] { return is_settled(); }, stop); !status) return status;
    update(0.0);
    if (!problem_.empty()) return fail(ErrorCode::invalid_argument, problem_);
    return {};
}

std::string Viewer::problem() const
{
    if (loading_error_) return describe(*loading_error_);
    return problem_.empty() ? live_problem_ : problem_;
}

void Viewer::forget_problem()
{
    loading_error_.reset();
    problem_.clear();
}

void Viewer::offer(Controls& controls)
{
    WatchedControls watched(controls);
    const std::vector<std::string_view> names = panel_names();
    std::size_t panel = panel_;
    if (watched.choice("panel", panel, names)) {
        const Box before = focus();
        leave_for(panel);
        problem_.clear();
        if (!same(before, focus())) frame();
        awaits_focus_ = !models_.empty();
    }
    panels_[panel_]->offer(watched);
    if (watched.changed()) ++wanted_;

    // What follows changes nothing that a task computes.
    choose(controls, "theme", theme_, std::array<std::string_view, 2>{"light", "dark"});
    constexpr double half_turn = 180.0;
    double azimuth = camera_.azimuth * half_turn / std::numbers::pi;
    double elevation = camera_.elevation * half_turn / std::numbers::pi;
    azimuth = std::remainder(azimuth, 2.0 * half_turn);
    if (controls.number("azimuth", azimuth, -half_turn, half_turn))
        camera_.azimuth = azimuth * std::numbers::pi / half_turn;
    if (controls.number("elevation", elevation, -0.5 * half_turn, 0.5 * half_turn))
        camera_.elevation = elevation * std::numbers::pi / half_turn;
    if (controls.button("show all")) frame_all();
}

Status Viewer::choose_panel(std::string_view name)
{
    const std::vector<std::string_view> names = panel_names();
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
        std::string all;
        for (const std::string_view one : names) all += concat(all.empty() ? "" : ", ", one);
        return fail(ErrorCode::invalid_argument,
                    concat('"', name, "\" is no panel: they are ", all));
    }
    leave_for(static_cast<std::size_t>(found - names.begin()));
    return {};
}

void Viewer::leave_for(std::size_t panel)
{
    panels_[panel_]->leave();
    panel_ = panel;
    // What is drawn stays until there is something new to see; the words are of the other panel.
    picture_.facts.clear();
    picture_.plots.clear();
    picture_.legend = {};
    picture_.focus.reset();
    ++wanted_;
}

std::vector<std::string_view> Viewer::panel_names() const
{
    std::vector<std::string_view> names;
    for (const auto& panel : panels_) names.push_back(panel->name());
    return names;
}

std::shared_ptr<const Progress> Viewer::progress() const noexcept
{
    if (loading_.is_busy()) return loading_.shared_progress();
    if (working_.is_busy()) return working_.shared_progress();
    return nullptr;
}

void Viewer::cancel() noexcept
{
    loading_.cancel();
    working_.cancel();
}

void Viewer::stop()
{
    cancel();
    if (loading_.is_busy()) (void)loading_.take();
    if (working_.is_busy()) (void)working_.take();
}

Backdrop Viewer::backdrop() const noexcept
{
    if (theme_ == Theme::light) return {};
    return {srgb(0x2B3038), srgb(0x15181D)};
}

std::vector<Vec3> Viewer::handles() const
{
    return models_.empty() ? std::vector<Vec3>{} : panels_[panel_]->handles();
}

void Viewer::resize(ViewSize size)
{
    const bool same_shape = size.width * size_.height == size.height * size_.width;
    size_ = size;
    if (!camera_is_set_ && !same_shape) frame();
}

void Viewer::frame_all()
{
    if (models_.empty()) return;
    Box box = panels_[panel_]->extent(models_);
    const Box drawn = bounding_box(picture_.layers);
    if (!drawn.empty()) {
        box.extend(drawn.lower);
        box.extend(drawn.upper);
    }
    frame(box);
}

Box Viewer::focus() const
{
    return picture_.focus ? *picture_.focus : panels_[panel_]->focus(models_);
}

void Viewer::frame()
{
    if (models_.empty()) return;
    frame(focus());
    awaits_focus_ = shown_ != wanted_;
}

void Viewer::keep_camera()
{
    camera_is_set_ = true;
    awaits_focus_ = false;
}

void Viewer::frame(const Box& box)
{
    camera_.up = models_.front()->up;
    // Around a box models are smaller than the picture: they are shown as large as they are.
    camera_ = same(box, bounding_box(models_))
                  ? framed(camera_, points_to_frame(models_), size_)
                  : framed(camera_, corners(box), size_, Framing::centered);
    camera_is_set_ = false;
    awaits_focus_ = false;
}

void Viewer::place_camera()
{
    CameraChoice& choice = options_.camera;
    if (!choice.eye && !choice.target) return;
    choice.camera = camera_;
    choice.size = size_;
    auto placed = placed_camera(choice, points_to_frame(models_));
    choice.eye = choice.target = std::nullopt;
    if (!placed) {
        loading_error_ = std::move(placed.error());
        return;
    }
    camera_ = *placed;
    keep_camera();
}

} // namespace proxima
