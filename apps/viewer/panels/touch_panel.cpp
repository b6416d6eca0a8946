// Touching a model with the mouse or a haptic device: device, proxy and force, as section 5.1 has
// them.
#include "base/text.h"
#include "haptics/loop/snapshot.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/exits.h"
#include "lab/hand_device.h"
#include "proxima/device.h"
#include "proxima/execution.h"
#include "proxima/haptic_renderer.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/panels/touch_device_choice.h"
#include "viewer/panels/touch_engine.h"
#include "viewer/scene_shapes.h"

#include <algorithm>
#include <fmt/core.h>
#include <optional>

namespace proxima {
namespace {

constexpr double pressed_depth = 0.08; // below the surface, per diagonal
constexpr double outside_height = 0.1; // above it, where the device begins

struct TouchPanelSettings {
    int model = 1;
    TouchOptions touch;
    TouchDeviceChoice device;
    PlacedPoint target;          ///< where the mouse pulls the device to
    std::optional<Vec3> outward; ///< out of the surface that is pressed, where it is known

    [[nodiscard]] bool by_mouse() const { return device.hand == Hand::mouse; }
};

const DeviceLimits& limits_of_mouse()
{
    static const DeviceLimits limits = find_device("touch").value_or(DeviceLimits{});
    return limits;
}

/// What there is to touch; shared with tasks, which make it.
struct Touchable {
    std::shared_ptr<const ViewModel> model;
    std::unique_ptr<const IndexContactSurface> surface;
};

struct TouchSlot {
    std::mutex mutex;
    std::shared_ptr<const Touchable> latest;
};

/// Where the mouse's device begins: outside of the surface that is pressed, or farther from the
/// model's middle than where the hand wants it.
Vec3 start_of(const TouchPanelSettings& settings, const ViewModel& model)
{
    const double size = model.box.extent().norm();
    if (settings.outward)
        return settings.target.at + (pressed_depth + outside_height) * size * *settings.outward;
    const Vec3 outward = settings.target.at - model.box.center();
    return settings.target.at + 0.3 * size * outward.stableNormalized();
}

/// Where the mouse's hand wants to go, m of the device: from the window's thread to the device's.
using MouseTarget = Snapshot<Vec3>;

/// The mouse's hand, which wants to go to the target.
TouchDevice pulled_hand(const std::shared_ptr<MouseTarget>& target,
                        const TouchPanelSettings& settings, const ViewModel& model)
{
    TouchDevice made;
    made.limits = limits_of_mouse();
    made.map = fit_workspace(model.box, made.limits.workspace_radius);
    made.device = std::make_unique<HandDevice>(
        "mouse", HandModel{.tick_seconds = TouchSession::tick_seconds},
        [target](double) {
            target->update();
            return target->reading();
        },
        made.map.to_device(start_of(settings, model)), made.limits);
    return made;
}

/// Where the mouse wants the device, in the device's metres.
Vec3 target_position(const TouchPanelSettings& settings, const ViewModel& model)
{
    return fit_workspace(model.box, limits_of_mouse().workspace_radius)
        .to_device(settings.target.at);
}

void add_moment(PanelPicture& picture, const TouchMoment& moment, double size)
{
    auto scene = std::make_shared<DrawnScene>();
    constexpr double most_force = 3.3; // N, as long as half of the model
    add_ball(*scene, moment.device, 0.006 * size,
             {.name = "device", .color = srgb(figure_colors::blue), .lift = 0.2});
    add_ball(*scene, moment.proxy, 0.011 * size,
             {.name = "proxy",
              .color = moment.hold == Hold::free ? srgb(0x9AA3AF) : srgb(figure_colors::yellow)});
    const double force = moment.force.norm();
    if (force > 1e-3) {
        const Vec3 arrow = 0.5 * size / most_force * moment.force;
        add_arrow(*scene, moment.proxy, moment.proxy + arrow, 0.004 * size,
                  {.name = "force", .color = srgb(figure_colors::red)});
    }
    scene->lines.push_back({"spring", {{moment.device, moment.proxy}}, srgb(0x222222), 1.5});
    picture.layers.push_back({std::move(scene)});
    picture.facts.push_back({"contact", std::string(word_of(moment.hold))});
    picture.facts.push_back({"force", fmt::format("{:.3f} N", force)});
    if (moment.rate > 0.0) {
        picture.facts.push_back({"servo rate", fmt::format("{:.0f} Hz", moment.rate)});
        picture.facts.push_back(
            {"longest interval", fmt::format("{:.2f} ms", 1e3 * moment.worst_interval)});
    }
    picture.plots.push_back(
        {"force over two seconds (N)", {moment.forces.begin(), moment.forces.end()}, false});
}

class TouchPanel final : public Panel {
public:
    explicit TouchPanel(Pictures pictures) : pictures_(pictures) {}

    [[nodiscard]] std::string_view name() const override { return "touch"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "Touch the model: drag the ring, which pulls a device (blue) through a simulated "
               "hand, or choose a haptic device. The proxy (yellow) stays on the surface, the "
               "force (red) pulls the device back to it. A click presses a point; the wheel moves "
               "the ring to and fro while it is held.";
    }

    void models_changed(const ViewModels& models, const Vec3& to_eye) override
    {
        leave();
        models_ = models;
        slot_ = std::make_shared<TouchSlot>();
        settings_.model = std::clamp(settings_.model, 1, static_cast<int>(models.size()));
        const double size = model()->box.extent().norm();
        const PointWithNormal pressed = visible_point(*model(), to_eye, outside_height);
        if (settings_.target.is_untouched()) settings_.outward = pressed.normal;
        settings_.target.place(pressed.above(-pressed_depth * size));
    }

    void offer(Controls& controls) override
    {
        offer_model(controls, settings_.model, models_.size());
        TouchOptions& touch = settings_.touch;
        bool changed = settings_.device.offer(controls);
        changed = controls.number("stiffness", touch.stiffness, 10.0, 1000.0) || changed;
        changed = controls.number("damping", touch.damping, 0.0, 4.0) || changed;
        changed = controls.number("static friction", touch.static_friction, 0.0, 1.5) || changed;
        changed = controls.number("dynamic friction", touch.dynamic_friction, 0.0, 1.5) || changed;
        if (changed) engine_.reset(); // begins anew with these
        const OfferedIf by_mouse(controls, "device=mouse", settings_.by_mouse());
        const Vec3 before = settings_.target.at;
        settings_.target.offer(controls, "hand", models_);
        if (settings_.target.at != before) settings_.outward.reset();
    }

    [[nodiscard]] std::vector<Vec3> handles() const override
    {
        if (!settings_.by_mouse()) return {};
        return {settings_.target.at};
    }
    void move_handle(std::size_t /*handle*/, const Vec3& to) override
    {
        settings_.target.set(to);
        settings_.outward.reset();
    }
    bool picked(const PickedPoint& hit) override
    {
        settings_.model = static_cast<int>(hit.model) + 1;
        // A little below the surface, so that there is a force.
        const ViewModel& touched = *models_[hit.model];
        const Vec3 normal = scaled_normal(touched.mesh.triangle(hit.triangle)).stableNormalized();
        settings_.outward = normal;
        settings_.target.set(hit.point - pressed_depth * touched.box.extent().norm() * normal);
        return true;
    }

    /// The point that the mouse presses; a device may go anywhere.
    [[nodiscard]] Box focus(const ViewModels& models) const override
    {
        if (models.empty() || !settings_.by_mouse()) return extent(models);
        return close_up(*model(), settings_.target.at, 0.12);
    }

    [[nodiscard]] bool is_moving() const override { return engine_ != nullptr; }

    /// The contact surface, and for pictures without a window a second of touching from outside.
    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, model = model(), settings = settings_, slot = slot_,
                pictures = pictures_](const Execution& context) -> Result<PanelPicture> {
            if (pictures == Pictures::still && !settings.by_mouse()) {
                return fail(ErrorCode::invalid_argument,
                            concat(settings.device.device(),
                                   " needs the window: a picture is touched by the mouse's hand"),
                            "device");
            }
            const auto touchable = touchable_of(*slot, model, context);
            if (!touchable) return tl::unexpected(touchable.error());
            PanelPicture picture;
            picture.layers = model_layers(models, Smoothing::smooth);
            picture.legend.entries = {{figure_colors::blue, "device"},
                                      {figure_colors::yellow, "proxy"},
                                      {figure_colors::red, "force"}};
            if (pictures == Pictures::still) {
                constexpr int ticks = 1000;
                const auto target =
                    std::make_shared<MouseTarget>(target_position(settings, *model));
                TouchSession session(*(*touchable)->surface, pulled_hand(target, settings, *model),
                                     settings.touch);
                for (int i = 0; i < ticks; ++i) session.tick();
                add_moment(picture, session.moment(), model->box.extent().norm());
            }
            return picture;
        };
    }

    void add_live(PanelPicture& picture) override
    {
        if (pictures_ == Pictures::still || models_.empty()) return;
        {
            const std::scoped_lock lock(slot_->mutex);
            if (slot_->latest && slot_->latest->model == model() && touched_ != slot_->latest) {
                engine_.reset();
                touched_ = slot_->latest;
            }
        }
        if (!touched_) return;
        const ViewModel& touched = *touched_->model;
        if (!engine_) start(touched);
        if (!engine_) {
            picture.problem = problem_;
            return;
        }
        if (settings_.by_mouse()) {
            target_->writing() = target_position(settings_, touched);
            target_->publish();
        } else {
            const TouchDeviceState device = engine_->device();
            picture.problem = device.problem;
            if (!device.problem.empty()) return;
            picture.facts.push_back({"device", device.words.empty() ? "is opened" : device.words});
            picture.facts.push_back({"state", std::string(word_of(engine_->moment().condition))});
        }
        const TouchMoment& moment = engine_->moment();
        if (moment.placed) add_moment(picture, moment, touched.box.extent().norm());
    }

    void leave() override
    {
        engine_.reset();
        touched_.reset();
    }

private:
    static Result<std::shared_ptr<const Touchable>>
    touchable_of(TouchSlot& slot, const std::shared_ptr<const ViewModel>& model,
                 const Execution& context)
    {
        {
            const std::scoped_lock lock(slot.mutex);
            if (slot.latest && slot.latest->model == model) return slot.latest;
        }
        // Built without the lock, for which the window would wait. A model without exits, for which
        // there may be no memory, can be touched too.
        auto with = with_exits(model->rays, context);
        if (!with && with.error().code == ErrorCode::cancelled) return tl::unexpected(with.error());
        auto surface = IndexContactSurface::make(with.value_or(model->rays));
        if (!surface) return tl::unexpected(surface.error());
        auto made = std::make_shared<Touchable>();
        made->model = model;
        made->surface = std::move(*surface);
        const std::scoped_lock lock(slot.mutex);
        slot.latest = std::move(made);
        return slot.latest;
    }

    [[nodiscard]] const std::shared_ptr<const ViewModel>& model() const
    {
        return models_[static_cast<std::size_t>(settings_.model - 1)];
    }

    /// Without a device where the axes are none.
    void start(const ViewModel& touched)
    {
        problem_.clear();
        TouchOptions options = settings_.touch;
        if (settings_.by_mouse()) {
            target_ = std::make_shared<MouseTarget>(target_position(settings_, touched));
            engine_ = std::make_unique<TouchEngine>(
                *touched_->surface,
                [target = target_, settings = settings_, model = touched_->model] {
                    return Result<TouchDevice>(pulled_hand(target, settings, *model));
                },
                options);
            return;
        }
        const auto axes = settings_.device.rotation(touched.up);
        if (!axes) {
            problem_ = describe(axes.error());
            return;
        }
        options.axes = *axes;
        engine_ = std::make_unique<TouchEngine>(
            *touched_->surface,
            [choice = settings_.device, model = touched_->model] { return choice.open(*model); },
            options);
    }

    TouchPanelSettings settings_;
    ViewModels models_;
    Pictures pictures_;
    std::shared_ptr<TouchSlot> slot_ = std::make_shared<TouchSlot>();
    std::shared_ptr<const Touchable> touched_;
    std::shared_ptr<MouseTarget> target_;
    std::string problem_;                 ///< of the device's settings
    std::unique_ptr<TouchEngine> engine_; // uses what is touched
};

} // namespace

std::unique_ptr<Panel> make_touch_panel(Pictures pictures)
{
    return std::make_unique<TouchPanel>(pictures);
}

} // namespace proxima
