#include "viewer/panels/placed_point.h"

#include "base/text.h"
#include "cli/camera.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace proxima {
namespace {

/// A model seen from far away. Points of the picture are to the right of its middle and above it,
/// in the model's units.
class SeenSurface {
public:
    SeenSurface(const ViewModel& model, const Vec3& to_eye)
        : model_(&model), to_eye_(to_eye), right_(model.up.cross(to_eye))
    {
        right_ = right_.isZero(1e-9) ? model.up.unitOrthogonal() : right_.normalized().eval();
        up_ = to_eye.cross(right_);
    }

    [[nodiscard]] const Vec3& right() const noexcept { return right_; }
    [[nodiscard]] const Vec3& up() const noexcept { return up_; }
    [[nodiscard]] double size() const { return model_->box.extent().norm(); }

    /// In front of all of the model.
    [[nodiscard]] Vec3 origin(double x, double y) const
    {
        return model_->box.center() + x * right_ + y * up_ + size() * to_eye_;
    }
    [[nodiscard]] std::optional<RayHit> at(double x, double y) const
    {
        return closest_hit(model_->rays, {.origin = origin(x, y), .direction = -to_eye_});
    }

    /// How much of the surface round a point lies in its tangent plane, 0 to 1: little in a bore or
    /// on a rim.
    [[nodiscard]] double share_around(double x, double y, const PointWithNormal& point) const
    {
        constexpr int around = 8;
        const double radius = 0.06 * size();
        int like_it = 0;
        for (int i = 0; i < around; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / around;
            const double beside_x = x + radius * std::cos(angle);
            const double beside_y = y + radius * std::sin(angle);
            const auto hit = at(beside_x, beside_y);
            if (!hit) continue;
            const Vec3 beside = origin(beside_x, beside_y) - hit->t * to_eye_;
            if (std::abs(point.normal.dot(beside - point.point)) < 0.4 * radius) ++like_it;
        }
        return static_cast<double>(like_it) / around;
    }

private:
    const ViewModel* model_;
    Vec3 to_eye_;
    Vec3 right_;
    Vec3 up_;
};

struct Candidate {
    PointWithNormal at;
    double score = 0.0;
};

} // namespace

Vec3 point_at_offset(const ViewModel& model, double right, double front, double up)
{
    const View view({.azimuth = 0.0, .elevation = 0.0, .up = model.up}, {});
    return model.box.center() + model.box.extent().norm() *
                                    (right * view.right() + front * view.back() + up * view.up());
}

PointWithNormal visible_point(const ViewModel& model, const Vec3& to_eye, double height)
{
    const SeenSurface seen(model, to_eye);
    // Facing the eye, and tilted upward, so that what stands on it is seen from the side.
    const Vec3 best_normal = (0.75 * to_eye + 0.55 * seen.up() + 0.35 * seen.right()).normalized();
    std::vector<Candidate> candidates;
    constexpr int steps = 12; // from the middle to each side
    for (int i = -steps; i <= steps; ++i) {
        for (int j = -steps; j <= steps; ++j) {
            const double x = 0.5 * seen.size() * i / steps;
            const double y = 0.5 * seen.size() * j / steps;
            const auto hit = seen.at(x, y);
            if (!hit) continue;
            Vec3 normal = scaled_normal(model.mesh.triangle(hit->triangle)).stableNormalized();
            if (normal.dot(to_eye) < 0.0) normal = -normal;
            if (normal.dot(to_eye) < 0.2) continue;
            const double from_middle = std::hypot(x, y) / seen.size();
            const PointWithNormal at = {seen.origin(x, y) - hit->t * to_eye, normal};
            candidates.push_back(
                {at, normal.dot(best_normal) + seen.share_around(x, y, at) - 0.5 * from_middle});
        }
    }
    std::ranges::sort(candidates, std::ranges::greater{}, &Candidate::score);
    const double above = height * seen.size();
    const auto is_open = [&](const Candidate& candidate) {
        const Vec3 point = candidate.at.above(above);
        const auto nearest = closest_feature(model.rays, point);
        return nearest && nearest->squared_distance > 0.8 * above * above &&
               !any_hit(model.rays, {.origin = point, .direction = to_eye}) &&
               !any_hit(model.rays, {.origin = point, .direction = candidate.at.normal});
    };
    if (const auto open = std::ranges::find_if(candidates, is_open); open != candidates.end())
        return open->at;
    if (!candidates.empty()) return candidates.front().at;
    // No surface is seen from in front: the vertex nearest to the eye.
    const auto positions = model.mesh.positions();
    const auto nearest = std::ranges::max_element(
        positions, {}, [&](const Vec3& position) { return to_eye.dot(position); });
    return {*nearest, to_eye};
}

Box close_up(const ViewModel& model, const Vec3& point, double least)
{
    constexpr double edges = 5.0;
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
        const auto k = static_cast<std::size_t>(axis);
        if (!controls.number(concat(name, axes[k]), at[axis], least, most)) continue;
        // The others stay where they are seen.
        if (box.empty()) {
            is_set[k] = true;
        } else {
            is_set.fill(true);
        }
    }
}

} // namespace proxima
