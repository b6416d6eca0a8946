#include "proxima/cast_ray.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/index_parts.h"
#include "query/batch_size.h"
#include "query/rays/prepare_ray.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <limits>

#ifndef PROXIMA_QUERY_CAST_RAY_ONCE
#define PROXIMA_QUERY_CAST_RAY_ONCE

namespace proxima {

/// Takes a hit of the ray with this number in its batch.
using VisitNumberedHit = Flow (*)(void* context, std::uint32_t number, const RayHit& hit);

} // namespace proxima

#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/rays/cast_ray.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "query/rays/walk_batch-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Every hit, as it comes.
struct AllSearch {
    static constexpr bool has_packets = false;
    static constexpr bool notes_hits = false;
    const IndexParts& index;
    VisitNumberedHit visit;
    void* context;

    HWY_INLINE bool take(std::uint32_t leaf, const LeafCandidates& candidates,
                         SearchedRay& ray) const
    {
        for (std::uint32_t left = candidates.lanes; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            if (ask_any_triangle(index, {leaf, lane}, ray, ray.best) &&
                visit(context, ray.number, ray.best) == Flow::stop)
                return false;
        }
        return true;
    }
    HWY_INLINE void settle(SearchedRay& /*ray*/) const {}
};

template <class Search>
HWY_INLINE void walk(const IndexParts& index, const Search& search, RayTraversal& ray)
{
    // On its own, so that it can stay in registers.
    WalkState at = ray.at;
    const IndexBlock* const blocks = index.blocks().data();
    while (step(blocks, search, ray, at)) {
        // The one to come after it.
        prefetch_block(blocks[ray.references[at.pending - 1] & ~index_leaf_bit]);
    }
    search.settle(ray);
}

RayStart walk_to_closest(const IndexParts& index, const Ray& ray, Faces faces, RayTraversal& open)
{
    const RayStart start = open_any_ray(index, ray, faces, open);
    if (start == RayStart::ready) walk(index, ClosestSearch<SureHits::computed>{index}, open);
    return start;
}
RayStart walk_to_any(const IndexParts& index, const Ray& ray, Faces faces, RayTraversal& open)
{
    const RayStart start = open_any_ray(index, ray, faces, open);
    if (start == RayStart::ready) walk(index, AnySearch{index}, open);
    return start;
}
RayStart walk_to_all(const IndexParts& index, const Ray& ray, Faces faces, VisitNumberedHit visit,
                     void* context)
{
    RayTraversal open;
    const RayStart start = open_any_ray(index, ray, faces, open);
    if (start == RayStart::ready) walk(index, AllSearch{index, visit, context}, open);
    return start;
}
void walk_all_to_closest(const IndexParts& index, const RaySource& source)
{
    walk_together(index, ClosestSearch<SureHits::noted>{index}, source);
}
void walk_all_to_any(const IndexParts& index, const RaySource& source)
{
    walk_together(index, AnySearch{index}, source);
}
void walk_all_to_all(const IndexParts& index, const RaySource& source, VisitNumberedHit visit,
                     void* context)
{
    walk_together(index, AllSearch{index, visit, context}, source);
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(walk_to_closest);
HWY_EXPORT(walk_to_any);
HWY_EXPORT(walk_to_all);
HWY_EXPORT(walk_all_to_closest);
HWY_EXPORT(walk_all_to_any);
HWY_EXPORT(walk_all_to_all);

namespace {

/// Tests every triangle in doubles, for rays that floats know nothing of, until visit returns
/// Flow::stop.
template <class Visit>
void ask_all(const IndexParts& index, const Ray& ray, Faces faces, const Visit& visit)
{
    for (std::uint32_t row = 0; row < index.triangle_count(); ++row) {
        const auto hit = ask_row(index, row, ray, faces);
        if (hit && visit(*hit) == Flow::stop) return;
    }
}

std::optional<RayHit> ask_for_closest(const IndexParts& index, const Ray& ray, Faces faces)
{
    std::optional<RayHit> closest;
    ask_all(index, ray, faces, [&](const RayHit& hit) {
        if (!closest || hit.before(*closest)) closest = hit;
        return Flow::proceed;
    });
    return closest;
}

bool ask_for_any(const IndexParts& index, const Ray& ray, Faces faces)
{
    bool found = false;
    ask_all(index, ray, faces, [&](const RayHit& /*hit*/) {
        found = true;
        return Flow::stop;
    });
    return found;
}

constexpr std::size_t no_ray = std::numeric_limits<std::size_t>::max();

/// The rays of a chunk. `answer(number, hit)` takes those whose walk has ended, with a hit or null,
/// `ask(number)` those that are too far for one.
template <class Answer, class Ask>
class ChunkTakers {
public:
    ChunkTakers(std::span<const Ray> rays, Faces faces, const Answer& answer, const Ask& ask)
        : rays_(rays), faces_(faces), answer_(answer), ask_(ask)
    {}

    [[nodiscard]] RaySource source() noexcept
    {
        return {rays_, faces_,
                [](void* context, std::uint32_t number, const RayHit* hit) {
                    static_cast<ChunkTakers*>(context)->answer_(number, hit);
                },
                [](void* context, std::uint32_t number, RayStart start) {
                    auto& takers = *static_cast<ChunkTakers*>(context);
                    if (start == RayStart::too_far) return takers.ask_(number);
                    takers.answer_(number, nullptr);
                    if (start == RayStart::invalid) {
                        takers.first_invalid_ =
                            std::min<std::size_t>(takers.first_invalid_, number);
                    }
                },
                this};
    }

    /// The lowest number of an invalid ray among those walked; no_ray where there is none.
    [[nodiscard]] std::size_t first_invalid() const noexcept { return first_invalid_; }

private:
    std::span<const Ray> rays_;
    Faces faces_;
    const Answer& answer_;
    const Ask& ask_;
    std::size_t first_invalid_ = no_ray;
};

constexpr std::size_t rays_per_task = RaySource::most_rays;

void keep_least(std::atomic<std::size_t>& least, std::size_t number) noexcept
{
    std::size_t now = least;
    while (number < now && !least.compare_exchange_weak(now, number)) {
    }
}

/// Walks all chunks: walk_chunk(first, rays) returns the number of an invalid ray in its chunk, or
/// none. The errors of batches.
template <class WalkChunk>
Status for_chunks(std::span<const Ray> rays, std::size_t answers, const RayBatchOptions& options,
                  const WalkChunk& walk_chunk)
{
    if (Status status = check_batch_size(answers, rays.size(), "rays"); !status) return status;
    begin_stage(options.execution.progress, "casting rays", rays.size());
    std::atomic<std::size_t> invalid = no_ray;
    parallel_chunks(rays.size(), rays_per_task, options.execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(options.execution.progress)) return;
                        const std::size_t number =
                            walk_chunk(first, rays.subspan(first, end - first));
                        if (number != no_ray) keep_least(invalid, first + number);
                        advance_stage(options.execution.progress, end - first);
                    });
    if (invalid != no_ray) {
        return fail(ErrorCode::invalid_argument,
                    concat("ray ", invalid.load(),
                           " is none: origin and direction must be finite, the direction not zero, "
                           "t_min at most t_max"),
                    "rays");
    }
    if (is_cancelled(options.execution.progress)) return cancelled("casting rays");
    return {};
}

bool before(const RayHit& a, const RayHit& b) noexcept
{
    return a.before(b);
}

} // namespace

std::optional<RayHit> closest_hit(const MeshIndex& index, const Ray& ray, Faces faces) noexcept
{
    RayTraversal open;
    const RayStart start = HWY_DYNAMIC_DISPATCH(walk_to_closest)(index.parts(), ray, faces, open);
    if (start == RayStart::too_far) return ask_for_closest(index.parts(), ray, faces);
    if (start != RayStart::ready || !open.found) return std::nullopt;
    return open.best;
}

bool any_hit(const MeshIndex& index, const Ray& ray, Faces faces) noexcept
{
    RayTraversal open;
    const RayStart start = HWY_DYNAMIC_DISPATCH(walk_to_any)(index.parts(), ray, faces, open);
    if (start == RayStart::too_far) return ask_for_any(index.parts(), ray, faces);
    return start == RayStart::ready && open.found;
}

void visit_hits(const MeshIndex& index, const Ray& ray, Faces faces,
                FunctionRef<Flow(const RayHit&)> visitor) noexcept
{
    const IndexParts& parts = index.parts();
    const auto pass_on = [](void* to, std::uint32_t /*number*/, const RayHit& hit) {
        return (*static_cast<const FunctionRef<Flow(const RayHit&)>*>(to))(hit);
    };
    const RayStart start = HWY_DYNAMIC_DISPATCH(walk_to_all)(parts, ray, faces, pass_on, &visitor);
    if (start == RayStart::too_far) ask_all(parts, ray, faces, visitor);
}

std::size_t all_hits(const MeshIndex& index, const Ray& ray, std::span<RayHit> hits,
                     Faces faces) noexcept
{
    std::size_t count = 0;
    // A heap, the last one on top, once the list is full.
    visit_hits(index, ray, faces, [&](const RayHit& hit) {
        if (count < hits.size()) {
            hits[count] = hit;
            if (count + 1 == hits.size()) std::ranges::make_heap(hits, before);
        } else if (!hits.empty() && hit.before(hits.front())) {
            std::ranges::pop_heap(hits, before);
            hits.back() = hit;
            std::ranges::push_heap(hits, before);
        }
        ++count;
        return Flow::proceed;
    });
    std::ranges::sort(hits.first(std::min(count, hits.size())), before);
    return count;
}

std::vector<RayHit> all_hits(const MeshIndex& index, const Ray& ray, Faces faces)
{
    std::vector<RayHit> hits;
    visit_hits(index, ray, faces, [&](const RayHit& hit) {
        hits.push_back(hit);
        return Flow::proceed;
    });
    std::ranges::sort(hits, before);
    return hits;
}

Status closest_hits(const MeshIndex& index, std::span<const Ray> rays,
                    std::span<std::optional<RayHit>> hits, const RayBatchOptions& options)
{
    return for_chunks(
        rays, hits.size(), options, [&](std::size_t first, std::span<const Ray> chunk) {
            const auto answer = [&](std::uint32_t number, const RayHit* hit) {
                hits[first + number] = hit != nullptr ? std::optional(*hit) : std::nullopt;
            };
            const auto ask = [&](std::uint32_t number) {
                hits[first + number] = ask_for_closest(index.parts(), chunk[number], options.faces);
            };
            ChunkTakers takers(chunk, options.faces, answer, ask);
            HWY_DYNAMIC_DISPATCH(walk_all_to_closest)(index.parts(), takers.source());
            return takers.first_invalid();
        });
}

Status any_hits(const MeshIndex& index, std::span<const Ray> rays, std::span<bool> hits,
                const RayBatchOptions& options)
{
    return for_chunks(
        rays, hits.size(), options, [&](std::size_t first, std::span<const Ray> chunk) {
            const auto answer = [&](std::uint32_t number, const RayHit* hit) {
                hits[first + number] = hit != nullptr;
            };
            const auto ask = [&](std::uint32_t number) {
                hits[first + number] = ask_for_any(index.parts(), chunk[number], options.faces);
            };
            ChunkTakers takers(chunk, options.faces, answer, ask);
            HWY_DYNAMIC_DISPATCH(walk_all_to_any)(index.parts(), takers.source());
            return takers.first_invalid();
        });
}

Result<RayHitLists> all_hits(const MeshIndex& index, std::span<const Ray> rays,
                             const RayBatchOptions& options)
{
    struct NumberedHit {
        std::uint32_t number; ///< of the ray in its chunk
        RayHit hit;
    };
    using Found = std::vector<NumberedHit>;
    std::vector<Found> found(chunk_count(rays.size(), rays_per_task));
    const Status status =
        for_chunks(rays, rays.size(), options, [&](std::size_t first, std::span<const Ray> chunk) {
            Found& hits = found[first / rays_per_task];
            const auto answer = [](std::uint32_t /*number*/, const RayHit* /*hit*/) {};
            const auto ask = [&](std::uint32_t number) {
                ask_all(index.parts(), chunk[number], options.faces, [&](const RayHit& hit) {
                    hits.push_back({number, hit});
                    return Flow::proceed;
                });
            };
            const auto keep = [](void* to, std::uint32_t number, const RayHit& hit) {
                static_cast<Found*>(to)->push_back({number, hit});
                return Flow::proceed;
            };
            ChunkTakers takers(chunk, options.faces, answer, ask);
            HWY_DYNAMIC_DISPATCH(walk_all_to_all)(index.parts(), takers.source(), keep, &hits);
            std::ranges::sort(hits, [](const NumberedHit& a, const NumberedHit& b) {
                return a.number < b.number || (a.number == b.number && a.hit.before(b.hit));
            });
            return takers.first_invalid();
        });
    if (!status) return tl::unexpected(status.error());
    RayHitLists lists;
    lists.first.assign(rays.size() + 1, 0);
    for (std::size_t task = 0; task < found.size(); ++task) {
        for (const NumberedHit& at : found[task]) {
            ++lists.first[task * rays_per_task + at.number + 1];
            lists.hits.push_back(at.hit);
        }
    }
    for (std::size_t i = 0; i < rays.size(); ++i) lists.first[i + 1] += lists.first[i];
    return lists;
}

} // namespace proxima

#endif
