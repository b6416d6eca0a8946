#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/length.h"
#include "index/visit_near.h"
#include "proxima/scene.h"
#include "query/batch_size.h"
#include "query/scene/scene_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr std::size_t scene_points_per_task = 256;

/// The box's distance from p, in the units of a tree, squared.
double squared_distance(const Box& box, const Vec3& p, double scale) noexcept
{
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double gap =
            scale * std::max({box.lower[axis] - p[axis], p[axis] - box.upper[axis], 0.0});
        squared += gap * gap;
    }
    return squared;
}

/// A search for the closest feature of a scene.
class SceneNearest {
public:
    SceneNearest(const SceneParts& scene, const Vec3& p,
                 const SceneFeatureOptions& options) noexcept
        : scene_(scene), p_(p), options_(options), radius_(options.radius),
          slack_(scene_roundoff * p.cwiseAbs().maxCoeff() + std::numeric_limits<double>::min())
    {}

    void search() noexcept
    {
        NearWalk walk(scene_.tree.parts(), {p_, p_}, limit());
        while (const IndexLeaf* const leaf = walk.next_leaf()) {
            visit(*leaf);
            walk.shrink(limit());
        }
    }

    [[nodiscard]] const std::optional<SceneFeature>& best() const noexcept { return best_; }

private:
    struct NearRow {
        double squared;
        std::uint32_t row;
    };

    /// Boxes beyond have nothing as near, in units of the tree, squared. Poses change lengths by 2^-29
    /// at most.
    [[nodiscard]] double limit() const noexcept
    {
        const double reach = (radius_ * (1 + 0x1p-28) + slack_) * scene_.tree.parts().scale();
        return reach * reach;
    }

    void visit(const IndexLeaf& leaf) noexcept
    {
        std::array<NearRow, 8> near{};
        std::size_t count = 0;
        for (std::uint32_t row = leaf.first_row; row < leaf.first_row + leaf.count; ++row) {
            if ((scene_.rows[row].layers & options_.layers) == 0) continue;
            const double squared =
                squared_distance(scene_.rows[row].box, p_, scene_.tree.parts().scale());
            std::size_t position = count++;
            for (; position > 0 && near[position - 1].squared > squared; --position)
                near[position] = near[position - 1];
            near[position] = {squared, row};
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (near[i].squared <= limit() * (1 + 0x1p-40) + std::numeric_limits<double>::min())
                ask(near[i].row);
        }
    }

    void ask(std::uint32_t at) noexcept
    {
        const SceneRow& row = scene_.rows[at];
        const Vec3 local = instance_frame(scene_.poses[at])(p_);
        double wanted = options_.radius;
        if (best_) {
            // Distances of answers are off from those that the index compares by their points' rounding,
            // which is half a step for each coordinate where doubles end.
            const double rounding =
                0x1p-48 * ((*scene_.shapes)[row.shape].reach + local.cwiseAbs().maxCoeff()) +
                2 * std::numeric_limits<double>::denorm_min();
            wanted = std::min(wanted, radius_ * (1 + 0x1p-40) + rounding);
        }
        const auto closest = closest_feature(scene_.index(row), local, {.radius = wanted});
        if (!closest) return;
        const double distance = length_of(local - closest->point);
        const InstanceId id{row.instance};
        if (best_ &&
            !(distance < best_->distance || (distance == best_->distance && id < best_->instance)))
            return;
        best_ = {id, *closest, scene_.poses[at](closest->point), distance};
        radius_ = std::min(radius_, distance);
    }

    const SceneParts& scene_;
    const Vec3& p_;
    const SceneFeatureOptions& options_;
    double radius_;
    double slack_;
    std::optional<SceneFeature> best_;
};

} // namespace

std::optional<SceneFeature> closest_feature(const Scene& scene, const Vec3& p,
                                            const SceneFeatureOptions& options) noexcept
{
    const SceneParts& parts = scene.parts();
    if (!p.allFinite() || !(options.radius >= 0) || parts.tree_rows() == 0) return std::nullopt;
    SceneNearest nearest(parts, p, options);
    nearest.search();
    return nearest.best();
}

Status closest_features(const Scene& scene, std::span<const Vec3> points,
                        std::span<std::optional<SceneFeature>> answers,
                        const SceneFeatureOptions& options)
{
    if (Status status = check_batch_size(answers.size(), points.size(), "points"); !status)
        return status;
    const auto wrong =
        std::ranges::find_if_not(points, [](const Vec3& p) { return p.allFinite(); });
    if (wrong != points.end()) {
        return fail(
            ErrorCode::invalid_argument,
            concat("point ", wrong - points.begin(), " has a coordinate that is not finite"),
            "points");
    }
    const Execution& execution = options.execution;
    begin_stage(execution.progress, "closest features", points.size());
    parallel_chunks(points.size(), scene_points_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        for (std::size_t i = first; i < end; ++i) {
                            if (is_cancelled(execution.progress)) return;
                            answers[i] = closest_feature(scene, points[i], options);
                        }
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
