// What the mouse does: turns, moves, goes nearer, drags handles and picks.
#include "viewer/viewer.h"

namespace proxima {
namespace {

constexpr double handle_reach = 14.0; // pixels
constexpr double click_reach = 4.0;   // pixels that a click may move

} // namespace

Ray Viewer::ray_at(const Vec2& at) const
{
    const View view(camera_, size_);
    return {.origin = view.eye(), .direction = view.direction(at)};
}

std::optional<std::size_t> Viewer::handle_at(const Vec2& at) const
{
    const View view(camera_, size_);
    const std::vector<Vec3> positions = handles();
    std::optional<std::size_t> best;
    double nearest = handle_reach;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (view.depth(positions[i]) <= 0.0) continue;
        const ScreenPoint seen = view.project(positions[i]);
        const double distance = (Vec2(seen.x, seen.y) - at).norm();
        if (distance > nearest) continue;
        nearest = distance;
        best = i;
    }
    return best;
}

void Viewer::press(MouseButton button, const Vec2& at, bool with_shift)
{
    pressed_at_ = mouse_ = at;
    moved_ = false;
    if (button != MouseButton::left || with_shift) {
        drag_ = Drag::pan;
    } else if (const auto handle = handle_at(at)) {
        drag_ = Drag::handle;
        handle_ = *handle;
    } else {
        drag_ = Drag::orbit;
    }
}

void Viewer::move(const Vec2& at)
{
    if (drag_ == Drag::none) return;
    const Vec2 step = at - mouse_;
    mouse_ = at;
    if ((at - pressed_at_).norm() > click_reach) moved_ = true;
    if (!moved_) return;
    if (drag_ == Drag::handle) {
        // In the plane through it that the picture is parallel to.
        const std::vector<Vec3> positions = handles();
        if (handle_ >= positions.size()) return;
        const View view(camera_, size_);
        panels_[panel_]->move_handle(handle_, view.eye() + view.depth(positions[handle_]) *
                                                               view.direction(at));
        ++wanted_;
        return;
    }
    camera_ = drag_ == Drag::orbit ? orbited(camera_, step, size_) : panned(camera_, step, size_);
    keep_camera();
}

void Viewer::release(const Vec2& at)
{
    if (drag_ == Drag::orbit && !moved_) click(at);
    drag_ = Drag::none;
}

void Viewer::click(const Vec2& at)
{
    picked_ = pick(models_, ray_at(at));
    if (picked_ && panels_[panel_]->picked(*picked_)) ++wanted_;
}

void Viewer::double_click(const Vec2& at)
{
    const auto hit = pick(models_, ray_at(at));
    if (!hit) return;
    const View view(camera_, size_);
    // The eye moves with the target and stays as far from it as it is from that point now.
    camera_.distance = view.depth(hit->point);
    camera_.target = hit->point;
    keep_camera();
}

void Viewer::wheel(double steps)
{
    if (drag_ == Drag::handle) {
        // Away from the eye, or towards it.
        const std::vector<Vec3> positions = handles();
        if (handle_ >= positions.size()) return;
        constexpr double part_of_depth = 0.02;
        const View view(camera_, size_);
        const Vec3 away = positions[handle_] - view.eye();
        panels_[panel_]->move_handle(handle_, positions[handle_] + part_of_depth * steps * away);
        moved_ = true;
        ++wanted_;
        return;
    }
    camera_ = zoomed(camera_, steps);
    keep_camera();
}

} // namespace proxima
