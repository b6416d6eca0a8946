// A panel of the viewer: settings that a person changes, and the picture that follows from them.
//
//     settings ──offer()──> a person            no OpenGL, no window: tests and the command line
//        │                                       use panels as the window does
//        └─────task()────> PanelTask ──in the background──> PanelPicture: layers, facts, plots
//
// A task holds copies of the settings and shares what was built before (Kept), so the panel may be
// changed while it runs. Handles are points that the mouse drags.
#pragma once

#include "cli/legend.h"
#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/controls.h"
#include "viewer/scene_shapes.h"
#include "viewer/view_models.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace proxima {

/// A line of numbers beside the picture.
struct PanelFact {
    std::string name;
    std::string value;
};

/// A curve or a histogram beside the picture.
struct PanelPlot {
    std::string name;
    std::vector<float> values;
    bool bars = false;
};

struct PanelPicture {
    std::vector<SceneLayer> layers;
    std::vector<PanelFact> facts;
    std::vector<PanelPlot> plots;
    Legend legend = {};            ///< what the colours mean
    std::string problem = {};      ///< what failed although there is a picture; else empty
    std::optional<Box> focus = {}; ///< what to show at first, where that is work (Panel::focus)
};

using PanelTask = std::function<Result<PanelPicture>(const Execution&)>;

/// What a panel built last, and for which key. Tasks of one panel run one after another.
template <class Key, class Value>
class Kept {
public:
    /// The value for the key: the stored one, or a new one by build() -> Result<Value>.
    template <class Build>
    [[nodiscard]] Result<std::shared_ptr<const Value>> get(const Key& key, const Build& build)
    {
        const std::scoped_lock lock(mutex_);
        if (value_ && key_ == key) return value_;
        auto built = build();
        if (!built) return tl::unexpected(built.error());
        value_ = std::make_shared<const Value>(std::move(*built));
        key_ = key;
        return value_;
    }

private:
    std::mutex mutex_;
    std::optional<Key> key_;
    std::shared_ptr<const Value> value_;
};

class Panel {
public:
    Panel() = default;
    Panel(const Panel&) = delete;
    Panel& operator=(const Panel&) = delete;
    virtual ~Panel() = default;

    /// One word: "octree".
    [[nodiscard]] virtual std::string_view name() const = 0;
    /// What it shows, in one sentence, and what the mouse does.
    [[nodiscard]] virtual std::string_view purpose() const = 0;

    /// The models have changed: points that depend on them are set anew, except those that a person
    /// has set. `to_eye` is the unit direction to the eye that looks at the models.
    virtual void models_changed(const ViewModels& models, const Vec3& to_eye) = 0;

    /// Offers the settings. Controls change them in place.
    virtual void offer(Controls& controls) = 0;

    /// The task that makes the picture for the present settings. \pre there are models
    [[nodiscard]] virtual PanelTask task(const ViewModels& models) const = 0;

    /// The box that a picture should show: the models', unless the panel shows something else.
    [[nodiscard]] virtual Box extent(const ViewModels& models) const
    {
        return bounding_box(models);
    }

    /// The box that a picture shows at first: a part of the extent if the panel's subject is small.
    /// Asked for on the thread of the window: where it takes longer than the extent, the task finds
    /// it, as PanelPicture::focus.
    [[nodiscard]] virtual Box focus(const ViewModels& models) const { return extent(models); }

    /// Points to drag; none by default.
    [[nodiscard]] virtual std::vector<Vec3> handles() const { return {}; }
    virtual void move_handle(std::size_t /*handle*/, const Vec3& /*to*/) {}

    /// A click on a model. True where it changed a setting.
    virtual bool picked(const PickedPoint& /*hit*/) { return false; }

    /// Time passes. True where that changed a setting.
    virtual bool advance(double /*seconds*/) { return false; }

    /// Whether something moves by itself.
    [[nodiscard]] virtual bool is_moving() const { return false; }

    /// Adds what moves by itself to a picture, in every frame.
    virtual void add_live(PanelPicture& /*picture*/) {}

    /// Called when another panel is chosen.
    virtual void leave() {}
};

/// Which of the models a panel is about, from 1. Before there are models any number will do.
inline void offer_model(Controls& controls, int& model, std::size_t models)
{
    constexpr std::size_t any = 1000;
    const OfferedIf several(controls, "several models", models != 1);
    controls.number("model", model, 1, static_cast<int>(models == 0 ? any : models));
}

/// live: pictures follow each other; still: a single picture has to show everything.
enum class Pictures : std::uint8_t { live, still };

/// All panels, in the order in which they are offered.
[[nodiscard]] std::vector<std::unique_ptr<Panel>> make_panels(Pictures pictures);

/// The models as they are, as layers.
[[nodiscard]] std::vector<SceneLayer> model_layers(const ViewModels& models, Smoothing smoothing);

} // namespace proxima
