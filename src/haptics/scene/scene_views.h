// The views of a scene, one for each tool that touches it, and the one that the scene itself has.
//
// A view (moving_surface.h) belongs to one servo loop at a time. The first tool takes the scene's own;
// further ones get new views, which end with them.
#pragma once

#include "haptics/scene/moving_surface.h"
#include "haptics/scene/scene_input.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>

namespace proxima {

class SceneViews;

/// Whether a tool feels objects that are added while it has a view.
enum class AddedObjects : bool { felt, unfelt };

/// Gives a view back when its tool ends.
struct GiveViewBack {
    SceneViews* views = nullptr;
    void operator()(MovingSurface* view) const noexcept;
};
/// A tool's view. The scene must outlive it.
using SceneView = std::unique_ptr<MovingSurface, GiveViewBack>;

class PROXIMA_HIDDEN SceneViews {
public:
    explicit SceneViews(const Box& bounds);

    [[nodiscard]] SceneInput& input() noexcept { return input_; }
    /// The scene's own view, which the first tool has. Its address does not change.
    [[nodiscard]] MovingSurface& own() noexcept { return *views_.front(); }
    [[nodiscard]] const MovingSurface& own() const noexcept { return *views_.front(); }

    /// Like TouchScene::add().
    [[nodiscard]] Result<ObjectId> add(std::shared_ptr<const ContactBody> body,
                                       const RigidTransform& pose);

    /// A view for a tool, with objects where they are now; add() fails while one has it that would not
    /// feel what is added. Any thread, while others run. Error invalid_argument: too many tools.
    [[nodiscard]] Result<SceneView> take(AddedObjects added = AddedObjects::felt);

private:
    friend struct GiveViewBack;
    void give_back(const MovingSurface* view) noexcept;

    SceneInput input_;
    std::mutex mutex_; ///< of the next three; no servo loop takes it
    std::array<std::unique_ptr<MovingSurface>, max_scene_tools> views_;
    std::array<bool, max_scene_tools> taken_{};
    std::array<AddedObjects, max_scene_tools> added_{}; ///< `felt` where not taken
};

} // namespace proxima
