#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/visit_near.h"
#include "proxima/scene.h"
#include "query/batch_size.h"
#include "query/scene/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr std::size_t scene_points_per_task = 256;

/// Also where squares leave the doubles.
double length_of(const Vec3& v) noexcept
{
    const double largest = v.cwiseAbs().maxCoeff();
    if (!(largest > 0) || !std::isfinite(largest)) return largest;
    const double scale = std::ldexp(1.0, -std::clamp(std::ilogb(largest), -1000, 1000));
    const double x = v[0] * scale;
    const double y = v[1] * scale;
    const double z = v[2] * scale;
    return std::sqrt((x * x + y * y) + z * z) / scale;
}

/// Of what is as near as `distance` in an instance's coordinates, the box is no farther.
double farthest_box(double distance, double slack) noexcept
{
    // Poses change lengths by 2^-29 at most.
    return distance * (1 + 0x1p-28) + slack;
}

/// The box's distance from p, squared.
double squared_distance(const Box& box, const Vec3& p) noexcept
{
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double gap = std::max({box.lower[axis] - p[axis], p[axis] - box.upper[axis], 0.0});
        squared += gap * gap;
    }
    return squared;
}

} // namespace

std::optional<SceneFeature> closest_feature(const Scene& scene, const Vec3& p,
                                            const SceneFeatureOptions& options) noexcept
{
    const SceneParts& parts = scene.parts();
    if (!p.allFinite() || !(options.radius >= 0) || parts.tree_rows() == 0) return std::nullopt;
    const double slack =
        scene_roundoff * p.cwiseAbs().maxCoeff() + std::numeric_limits<double>::min();
    std::optional<SceneFeature> best;
    double radius = options.radius;
    const auto limit_of = [&](double distance) {
        const double reach = farthest_box(distance, slack);
        return reach * reach;
    };
    const auto visit = [&](std::uint32_t at) {
        const SceneRow& row = parts.rows[at];
        const Vec3 local = instance_frame(parts.poses[at])(p);
        // Squares are rounded: what is as near must not be left out.
        const double wanted = best ? radius * (1 + 0x1p-40) : radius;
        const auto closest = closest_feature(parts.index(row), local, {.radius = wanted});
        if (!closest) return;
        const double distance = length_of(local - closest->point);
        const InstanceId id{row.instance};
        if (best &&
            !(distance < best->distance || (distance == best->distance && id < best->instance)))
            return;
        best = {id, *closest, parts.poses[at](closest->point), distance};
        radius = std::min(radius, distance);
    };
    visit_near(parts.tree.parts(), {p, p}, limit_of(radius), [&](RowRange range) noexcept {
        std::array<std::pair<double, std::uint32_t>, 8> near{};
        std::size_t count = 0;
        for (std::uint32_t row = range.first; row < range.first + range.count; ++row) {
            if ((parts.rows[row].layers & options.layers) == 0) continue;
            near[count++] = {squared_distance(parts.rows[row].box, p), row};
        }
        std::sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count));
        for (std::size_t i = 0; i < count; ++i) {
            if (near[i].first > limit_of(radius) * (1 + 0x1p-40)) break;
            visit(near[i].second);
        }
        return limit_of(radius);
    });
    return best;
}

Status closest_features(const Scene& scene, std::span<const Vec3> points,
                        std::span<std::optional<SceneFeature>> answers,
                        const SceneFeatureOptions& options)
{
    if (Status status = check_batch_size(answers.size(), points.size(), "points"); !status)
        return status;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].allFinite()) continue;
        return fail(ErrorCode::invalid_argument,
                    concat("point ", i, " has a coordinate that is not finite"), "points");
    }
    const Execution& execution = options.execution;
    begin_stage(execution.progress, "closest features", points.size());
    parallel_chunks(points.size(), scene_points_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(execution.progress)) return;
                        for (std::size_t i = first; i < end; ++i)
                            answers[i] = closest_feature(scene, points[i], options);
                        advance_stage(execution.progress, end - first);
                    });
    if (is_cancelled(execution.progress)) return cancelled("closest features");
    return {};
}

void visit_instances(const Scene& scene, const Box& box, std::uint32_t layers,
                     FunctionRef<Flow(InstanceId)> visitor) noexcept
{
    const SceneParts& parts = scene.parts();
    if (box.empty() || !box.lower.allFinite() || !box.upper.allFinite()) return;
    visit_near(parts.tree.parts(), box, 0, [&](RowRange range) noexcept {
        for (std::uint32_t at = range.first; at < range.first + range.count; ++at) {
            const SceneRow& row = parts.rows[at];
            const bool apart = (row.box.lower.array() > box.upper.array()).any() ||
                               (box.lower.array() > row.box.upper.array()).any();
            if (apart || (row.layers & layers) == 0) continue;
            if (visitor(InstanceId{row.instance}) == Flow::stop) return -1.0;
        }
        return 0.0;
    });
}

} // namespace proxima
