// Touching a model with the mouse: device, proxy and force, as section 5.1 has them.
#include "viewer/figures/figure_colors.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/panels/touch_engine.h"
#include "viewer/scene_shapes.h"

#include <algorithm>
#include <fmt/core.h>

namespace proxima {
namespace {

struct TouchPanelSettings {
    int model = 1;
    TouchOptions touch;
    PlacedPoint hand; ///< where the mouse pulls the device to
};

/// What there is to touch; shared with tasks, which make it.
struct Touchable {
    std::shared_ptr<const ViewModel> model;
    std::shared_ptr<const ProximityOctree> octree;
    std::unique_ptr<OctreeContactSurface> surface;
};

struct TouchSlot {
    std::mutex mutex;
    std::shared_ptr<const Touchable> latest;
};

/// Where the device begins: farther from the model's middle than where the hand wants it.
Vec3 start_of(const TouchPanelSettings& settings, const ViewModel& model)
{
    const Vec3 outward = settings.hand.at - model.box.center();
    return settings.hand.at + 0.3 * model.box.extent().norm() * outward.stableNormalized();
}

void add_moment(PanelPicture& picture, const TouchMoment& moment, double size)
{
    auto scene = std::make_shared<Scene>();
    constexpr double most_force = 3.3; // N, as long as a third of the model
    add_ball(*scene, moment.device, 0.007 * size,
             {.name = "device", .color = srgb(figure_colors::blue), .lift = 2e-2});
    add_ball(*scene, moment.proxy, 0.015 * size,
             {.name = "proxy",
              .color = moment.hold == Hold::free ? srgb(0x9AA3AF) : srgb(figure_colors::yellow)});
    const double force = moment.force.norm();
    if (force > 1e-3) {
        const Vec3 arrow = 0.33 * size / most_force * moment.force;
        add_arrow(*scene, moment.proxy, moment.proxy + arrow, 0.006 * size,
                  {.name = "force", .color = srgb(figure_colors::red)});
    }
    scene->lines.push_back({"spring", {{moment.device, moment.proxy}}, srgb(0x222222), 1.5});
    picture.layers.push_back({std::move(scene)});
    const char* const hold = moment.hold == Hold::free       ? "free"
                             : moment.hold == Hold::sticking ? "sticking"
                                                             : "sliding";
    picture.facts.push_back({"contact", hold});
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
    TouchPanel(std::shared_ptr<SharedProximity> proximity, Pictures pictures)
        : proximity_(std::move(proximity)), pictures_(pictures)
    {}

    [[nodiscard]] std::string_view name() const override { return "touch"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "Touch the model: drag the ring, which pulls a device (blue) through a simulated "
               "hand. The proxy (yellow) stays on the surface, the force (red) pulls the device "
               "back to it. A click presses a place; the wheel moves the ring to and fro while it "
               "is held.";
    }

    void models_changed(const ViewModels& models) override
    {
        leave();
        models_ = models;
        slot_ = std::make_shared<TouchSlot>();
        settings_.model = std::clamp(settings_.model, 1, static_cast<int>(models.size()));
        settings_.hand.place(place_by(*model(), 0.2, 0.07, 0.14));
    }

    void offer(Controls& controls) override
    {
        if (models_.size() > 1)
            controls.number("model", settings_.model, 1, static_cast<int>(models_.size()));
        TouchOptions& touch = settings_.touch;
        bool changed = controls.number("stiffness", touch.stiffness, 10.0, 1000.0);
        changed = controls.number("damping", touch.damping, 0.0, 4.0) || changed;
        changed = controls.number("static friction", touch.static_friction, 0.0, 1.5) || changed;
        changed = controls.number("dynamic friction", touch.dynamic_friction, 0.0, 1.5) || changed;
        if (changed) engine_.reset(); // begins anew with these
        settings_.hand.offer(controls, "hand", models_);
    }

    [[nodiscard]] std::vector<Vec3> handles() const override { return {settings_.hand.at}; }
    void move_handle(std::size_t /*handle*/, const Vec3& to) override { settings_.hand.set(to); }
    bool picked(const PickedPlace& place) override
    {
        settings_.model = static_cast<int>(place.model) + 1;
        // A little below the surface, so that it is felt.
        const ViewModel& touched = *models_[place.model];
        const Vec3 normal = scaled_normal(touched.mesh.triangle(place.triangle)).stableNormalized();
        settings_.hand.set(place.point - 0.04 * touched.box.extent().norm() * normal);
        return true;
    }

    [[nodiscard]] bool is_moving() const override { return engine_ != nullptr; }

    /// The octree, and for pictures without a window a second of touching from outside.
    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, model = model(), settings = settings_, proximity = proximity_, slot = slot_,
                pictures = pictures_](const WorkContext& context) -> Result<PanelPicture> {
            const auto octree = proximity_of(*proximity, model, context);
            if (!octree) return tl::unexpected(octree.error());
            const auto touchable = touchable_of(*slot, model, *octree);
            PanelPicture picture;
            picture.layers = model_layers(models, Smoothing::smooth);
            if (pictures == Pictures::still) {
                constexpr int ticks = 1000;
                const double size = model->box.extent().norm();
                TouchSimulation simulation(*touchable->surface, model->box, settings.touch,
                                           start_of(settings, *model));
                for (int i = 0; i < ticks; ++i) simulation.tick(settings.hand.at);
                add_moment(picture, simulation.moment(), size);
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
        if (!engine_) {
            engine_ = std::make_unique<TouchEngine>(*touched_->surface, touched_->model->box,
                                                    settings_.touch,
                                                    start_of(settings_, *touched_->model));
        }
        engine_->pull_to(settings_.hand.at);
        add_moment(picture, engine_->moment(), touched_->model->box.extent().norm());
    }

    void leave() override
    {
        engine_.reset();
        touched_.reset();
    }

private:
    static std::shared_ptr<const Touchable>
    touchable_of(TouchSlot& slot, const std::shared_ptr<const ViewModel>& model,
                 const std::shared_ptr<const ProximityOctree>& octree)
    {
        const std::scoped_lock lock(slot.mutex);
        if (slot.latest && slot.latest->octree == octree) return slot.latest;
        auto made = std::make_shared<Touchable>();
        made->model = model;
        made->octree = octree;
        made->surface = std::make_unique<OctreeContactSurface>(*octree);
        slot.latest = std::move(made);
        return slot.latest;
    }

    [[nodiscard]] const std::shared_ptr<const ViewModel>& model() const
    {
        return models_[static_cast<std::size_t>(settings_.model - 1)];
    }

    TouchPanelSettings settings_;
    ViewModels models_;
    std::shared_ptr<SharedProximity> proximity_;
    Pictures pictures_;
    std::shared_ptr<TouchSlot> slot_ = std::make_shared<TouchSlot>();
    std::shared_ptr<const Touchable> touched_;
    std::unique_ptr<TouchEngine> engine_; // uses what is touched
};

} // namespace

std::unique_ptr<Panel> make_touch_panel(std::shared_ptr<SharedProximity> proximity,
                                        Pictures pictures)
{
    return std::make_unique<TouchPanel>(std::move(proximity), pictures);
}

} // namespace proxima
