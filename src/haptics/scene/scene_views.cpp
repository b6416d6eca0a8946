#include "haptics/scene/scene_views.h"

#include "base/text.h"

#include <algorithm>
#include <utility>

namespace proxima {

void GiveViewBack::operator()(MovingSurface* view) const noexcept
{
    views->give_back(view);
}

SceneViews::SceneViews(const Box& bounds) : input_(bounds)
{
    views_.front() = std::make_unique<MovingSurface>(input_, 0);
}

Result<ObjectId> SceneViews::add(std::shared_ptr<const ContactBody> body,
                                 const RigidTransform& pose)
{
    const std::lock_guard lock(mutex_);
    if (std::ranges::find(added_, AddedObjects::unfelt) != added_.end()) {
        return fail(ErrorCode::invalid_argument,
                    "objects must be added before a ToolRenderer is made, which would not feel "
                    "them: destroy it, add the object, and make it anew");
    }
    auto id = input_.add(std::move(body), pose);
    if (!id) return id;
    for (const auto& view : views_) {
        if (view != nullptr) view->add(*id);
    }
    return id;
}

Result<SceneView> SceneViews::take(AddedObjects added)
{
    const std::lock_guard lock(mutex_);
    const auto free = std::ranges::find(taken_, false);
    if (free == taken_.end()) {
        return fail(ErrorCode::invalid_argument,
                    concat("a scene cannot have more than ", max_scene_tools,
                           " renderers at a time: destroy one first"));
    }
    const auto tool = static_cast<std::size_t>(free - taken_.begin());
    if (views_[tool] == nullptr) views_[tool] = std::make_unique<MovingSurface>(input_, tool);
    views_[tool]->start();
    *free = true;
    added_[tool] = added;
    return SceneView(views_[tool].get(), GiveViewBack{this});
}

void SceneViews::give_back(const MovingSurface* view) noexcept
{
    std::unique_ptr<const MovingSurface> ended; // after the lock
    const std::lock_guard lock(mutex_);
    for (std::size_t tool = 0; tool < max_scene_tools; ++tool) {
        if (views_[tool].get() != view) continue;
        taken_[tool] = false;
        added_[tool] = AddedObjects::felt;
        if (tool == 0) return;
        input_.leave(tool);
        ended = std::move(views_[tool]);
    }
}

} // namespace proxima
