#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/scene.h"
#include "query/batch_size.h"
#include "query/scene/found_lists.h"
#include "query/scene/scene_parts.h"
#include "query/scene/scene_ray.h"

#include <algorithm>
#include <atomic>

namespace proxima {

namespace {

constexpr std::size_t scene_rays_per_task = 256;

/// Calls answer(i) for all rays. Errors: those of batches of rays.
template <class Answer>
Status for_rays(std::span<const Ray> rays, std::size_t answers, const Execution& execution,
                const Answer& answer)
{
    if (Status status = check_batch_size(answers, rays.size(), "rays"); !status) return status;
    const auto wrong = std::ranges::find_if_not(rays, is_valid);
    if (wrong != rays.end()) {
        return fail(ErrorCode::invalid_argument,
                    concat("ray ", wrong - rays.begin(),
                           " is none: origin and direction must be finite, the direction not zero, "
                           "t_min at most t_max"),
                    "rays");
    }
    begin_stage(execution.progress, "casting rays", rays.size());
    parallel_chunks(rays.size(), scene_rays_per_task, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(execution.progress)) return;
                        for (std::size_t i = first; i < end; ++i) answer(i);
                        advance_stage(execution.progress, end - first);
                    });
    if (is_cancelled(execution.progress)) return cancelled("casting rays");
    return {};
}

} // namespace

std::optional<SceneHit> closest_hit(const Scene& scene, const Ray& ray,
                                    const SceneRayOptions& options) noexcept
{
    if (!is_valid(ray)) return std::nullopt;
    const SceneParts& parts = scene.parts();
    SceneRay walk(parts, ray);
    std::optional<SceneHit> best;
    Ray cut = ray;
    walk.walk(options.layers, [&](std::uint32_t at) {
        const SceneRow& row = parts.rows[at];
        const auto hit =
            closest_hit(parts.index(row), to_instance(parts.poses[at], cut), options.faces);
        if (!hit) return Flow::proceed;
        const SceneHit found = {InstanceId{row.instance}, *hit};
        if (best && !found.before(*best)) return Flow::proceed;
        best = found;
        cut.t_max = found.hit.t;
        walk.set_most(found.hit.t);
        return Flow::proceed;
    });
    return best;
}

bool any_hit(const Scene& scene, const Ray& ray, const SceneRayOptions& options) noexcept
{
    if (!is_valid(ray)) return false;
    const SceneParts& parts = scene.parts();
    SceneRay walk(parts, ray);
    bool found = false;
    walk.walk(options.layers, [&](std::uint32_t at) {
        found =
            any_hit(parts.index(parts.rows[at]), to_instance(parts.poses[at], ray), options.faces);
        return found ? Flow::stop : Flow::proceed;
    });
    return found;
}

void visit_hits(const Scene& scene, const Ray& ray, const SceneRayOptions& options,
                FunctionRef<Flow(const SceneHit&)> visitor) noexcept
{
    if (!is_valid(ray)) return;
    const SceneParts& parts = scene.parts();
    SceneRay walk(parts, ray);
    walk.walk(options.layers, [&](std::uint32_t at) {
        const SceneRow& row = parts.rows[at];
        Flow flow = Flow::proceed;
        visit_hits(parts.index(row), to_instance(parts.poses[at], ray), options.faces,
                   [&](const RayHit& hit) {
                       return flow = visitor(SceneHit{InstanceId{row.instance}, hit});
                   });
        return flow;
    });
}

std::vector<SceneHit> all_hits(const Scene& scene, const Ray& ray, const SceneRayOptions& options)
{
    std::vector<SceneHit> hits;
    visit_hits(scene, ray, options, [&](const SceneHit& hit) {
        hits.push_back(hit);
        return Flow::proceed;
    });
    std::ranges::sort(hits, [](const SceneHit& a, const SceneHit& b) { return a.before(b); });
    return hits;
}

Status closest_hits(const Scene& scene, std::span<const Ray> rays,
                    std::span<std::optional<SceneHit>> hits, const SceneRayOptions& options)
{
    return for_rays(rays, hits.size(), options.execution,
                    [&](std::size_t i) { hits[i] = closest_hit(scene, rays[i], options); });
}

Status any_hits(const Scene& scene, std::span<const Ray> rays, std::span<bool> hits,
                const SceneRayOptions& options)
{
    return for_rays(rays, hits.size(), options.execution,
                    [&](std::size_t i) { hits[i] = any_hit(scene, rays[i], options); });
}

Result<SceneHitLists> all_hits(const Scene& scene, std::span<const Ray> rays,
                               const SceneRayOptions& options)
{
    const Execution& execution = options.execution;
    const std::size_t tasks = chunk_count(rays.size(), scene_rays_per_task);
    const std::uint64_t taken = (rays.size() + 1) * sizeof(std::size_t);
    const std::uint64_t needed = taken + FoundLists<SceneHit>::bytes_of_tasks(tasks);
    if (Status status = check_budget(execution.budget, needed, "the hits of rays",
                                     "take fewer rays or raise the budget");
        !status)
        return tl::unexpected(status.error());
    SceneHitLists lists;
    lists.first.assign(rays.size() + 1, 0);
    FoundLists<SceneHit> found(tasks, execution.budget, taken);
    const Status status = for_rays(rays, rays.size(), execution, [&](std::size_t i) {
        if (found.is_over()) return;
        const std::vector<SceneHit> hits = all_hits(scene, rays[i], options);
        lists.first[i + 1] = hits.size();
        for (const SceneHit& hit : hits) found.add(i / scene_rays_per_task, hit);
    });
    if (!status) return tl::unexpected(status.error());
    if (found.is_over()) {
        return fail(ErrorCode::budget_exceeded,
                    concat("there are more than ", found.most(),
                           " hits, which the memory budget does not hold; take fewer rays, or "
                           "raise the budget"));
    }
    for (std::size_t i = 0; i < rays.size(); ++i) lists.first[i + 1] += lists.first[i];
    lists.hits = found.take();
    return lists;
}

} // namespace proxima
