// A panel of the viewer: settings that a person changes, and the picture that follows from them.
//
//     settings ──offer()──> a person            no OpenGL, no window: tests and the command line
//        │                                       use panels as the window does
//        └─────task()────> PanelTask ──in the background──> PanelPicture: layers, facts, plots
//
// A task holds copies of the settings and shares what was built before (Kept), so the panel may be
// changed while it runs. Handles are places that the mouse drags.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"
#include "viewer/controls.h"
#include "viewer/scene_shapes.h"
#include "viewer/view_models.h"

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
    std::string problem = {}; ///< what could not be done, though there is a picture; empty: nothing
};

using PanelTask = std::function<Result<PanelPicture>(const Execution&)>;

/// What a panel built last, and for which key. Tasks of one panel run one after another.
template <class Key, class Value>
class Kept {
public:
    /// The value for the key: the one there is, or what build() -> Result<Value> makes.
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

    /// Other models: places that depend on them are set anew, but for what a person has set.
    virtual void models_changed(const ViewModels& models) = 0;

    /// Settings, changed in place.
    virtual void offer(Controls& controls) = 0;

    /// What shows the settings as they are now. \pre there are models
    [[nodiscard]] virtual PanelTask task(const ViewModels& models) const = 0;

    /// What a picture should hold: the models, unless the panel shows something else.
    [[nodiscard]] virtual Box extent(const ViewModels& models) const
    {
        return bounding_box(models);
    }

    /// What a picture holds at first: all, unless what the panel is about is small beside it.
    [[nodiscard]] virtual Box focus(const ViewModels& models) const { return extent(models); }

    /// Places to drag; none by default.
    [[nodiscard]] virtual std::vector<Vec3> handles() const { return {}; }
    virtual void move_handle(std::size_t /*handle*/, const Vec3& /*to*/) {}

    /// A click on a model. True where it changed a setting.
    virtual bool picked(const PickedPlace& /*place*/) { return false; }

    /// Time passes. True where that changed a setting.
    virtual bool advance(double /*seconds*/) { return false; }

    /// Whether something moves by itself.
    [[nodiscard]] virtual bool is_moving() const { return false; }

    /// Over the picture, from moment to moment, where something moves by itself.
    virtual void add_live(PanelPicture& /*picture*/) {}

    /// Another panel is shown from now on.
    virtual void leave() {}
};

/// Whether pictures follow each other, or there is one that has to show all by itself.
enum class Pictures : std::uint8_t { live, still };

/// All panels, in the order in which they are offered.
[[nodiscard]] std::vector<std::unique_ptr<Panel>> make_panels(Pictures pictures);

/// The models as they are, as layers.
[[nodiscard]] std::vector<SceneLayer> model_layers(const ViewModels& models, Smoothing smoothing);

} // namespace proxima
