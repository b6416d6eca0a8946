#include "viewer/panels/placed_point.h"

#include "base/text.h"
#include "cli/camera.h"
#include "proxima/cast_ray.h"

#include <algorithm>
#include <array>

namespace proxima {

Vec3 point_at_offset(const ViewModel& model, double right, double front, double up)
{
    const View view({.azimuth = 0.0, .elevation = 0.0, .up = model.up}, {});
    return model.box.center() + model.box.extent().norm() *
                                    (right * view.right() + front * view.back() + up * view.up());
}

PointWithNormal visible_point(const ViewModel& model)
{
    const Vec3 outside = point_at_offset(model, 0.75, 0.35, 0.55);
    const Vec3 inward = model.box.center() - outside;
    if (const auto hit = closest_hit(model.rays, {.origin = outside, .direction = inward})) {
        const Vec3 normal = scaled_normal(model.mesh.triangle(hit->triangle)).stableNormalized();
        if (normal.dot(inward) < 0.0) return {outside + hit->t * inward, normal};
    }
    // Nothing is in the middle: the farthest vertex of that side.
    const auto positions = model.mesh.positions();
    const auto farthest = std::ranges::min_element(
        positions, {}, [&](const Vec3& position) { return inward.dot(position); });
    return {*farthest, -inward.stableNormalized()};
}

Box close_up(const ViewModel& model, const Vec3& point, double least)
{
    constexpr double edges = 8.0;
    constexpr double most = 0.4; // of the box: more is all of it
    const double half = std::max(least * model.box.extent().norm(), edges * model.edge);
    Box all = model.box;
    all.extend(point);
    if (half > most * model.box.extent().maxCoeff()) return all;
    return {point - Vec3::Constant(half), point + Vec3::Constant(half)};
}

void PlacedPoint::offer(Controls& controls, std::string_view name, const ViewModels& models)
{
    // Before there are models any number will do.
    constexpr double anywhere = 1e12;
    const Box box = bounding_box(models);
    constexpr std::array axes = {" x", " y", " z"};
    for (int axis = 0; axis < 3; ++axis) {
        double least = -anywhere;
        double most = anywhere;
        if (!box.empty()) {
            const double reach = 1.5 * box.extent().norm();
            least = std::min(box.center()[axis] - reach, at[axis]);
            most = std::max(box.center()[axis] + reach, at[axis]);
        }
        if (controls.number(concat(name, axes[static_cast<std::size_t>(axis)]), at[axis], least,
                            most))
            is_set = true;
    }
}

} // namespace proxima
