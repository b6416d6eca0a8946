#include "distributed/rays_over_ranks.h"

#include "distributed/ask_ranks.h"
#include "geometry/ray_triangle.h"
#include "proxima/cast_ray.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace proxima {

namespace {

struct RayQuestion {
    std::array<double, 3> origin = {};
    std::array<double, 3> direction = {};
    double t_min = 0;
    double t_max = 0;
};

/// A rank whose box a ray meets, by the least t that a hit there may have.
struct Entry {
    double t = -std::numeric_limits<double>::infinity();
    std::uint32_t rank = 0;

    [[nodiscard]] bool operator<(const Entry& other) const noexcept
    {
        return std::tie(t, rank) < std::tie(other.t, other.rank);
    }
};

/// The least t of a hit with a triangle in the box; nothing where there is none. More than t is
/// rounded by lies between it and any hit: t of a triangle is between those of its corners along the
/// direction's largest component, or, within 2^-21 of the largest of them, zero.
std::optional<double> first_t(const Ray& ray, const Box& box) noexcept
{
    constexpr double rounding = 0x1p-40;
    constexpr double doubt = 0x1p-20;
    if (box.empty()) return std::nullopt;
    int largest = 0;
    ray.direction.cwiseAbs().maxCoeff(&largest);
    double enter = -std::numeric_limits<double>::infinity();
    double leave = std::numeric_limits<double>::infinity();
    double least = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double origin = ray.origin[axis];
        const double slack =
            rounding * std::max({std::abs(origin), std::abs(box.lower[axis]),
                                 std::abs(box.upper[axis]), std::numeric_limits<double>::min()});
        const double lower = box.lower[axis] - slack - origin;
        const double upper = box.upper[axis] + slack - origin;
        if (ray.direction[axis] == 0) {
            if (lower > 0 || upper < 0) return std::nullopt;
            continue;
        }
        const auto [near, far] =
            std::minmax({lower / ray.direction[axis], upper / ray.direction[axis]});
        enter = std::max(enter, near);
        leave = std::min(leave, far);
        if (axis != largest) continue;
        const double first = std::clamp(near, -farthest_hit, farthest_hit);
        const double last = std::clamp(far, -farthest_hit, farthest_hit);
        least = first - doubt * std::max(std::abs(first), std::abs(last));
    }
    if (enter > leave || least > ray.t_max) return std::nullopt;
    return least;
}

std::vector<HitOfWhole> answer_rays(const MeshPart& part, std::span<const RayQuestion> questions)
{
    std::vector<Ray> rays;
    rays.reserve(questions.size());
    for (const RayQuestion& question : questions) {
        rays.push_back({Vec3(question.origin.data()), Vec3(question.direction.data()),
                        question.t_min, question.t_max});
    }
    std::vector<std::optional<RayHit>> hits(rays.size());
    // Cannot fail: sizes agree and the rays are valid.
    (void)closest_hits(part.index, rays, hits, {.execution = {.threads = {1}}});
    std::vector<HitOfWhole> answers(rays.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i]) continue;
        answers[i] = {hits[i]->t, part.triangles[to_index(hits[i]->triangle)], hits[i]->u,
                      hits[i]->v};
    }
    return answers;
}

class RayRounds {
public:
    RayRounds(const MeshPart& part, std::span<const Ray> rays, World& world)
        : part_(part), rays_(rays), world_(world), asked_(static_cast<std::size_t>(world.size()))
    {}

    Result<std::vector<HitOfWhole>> run()
    {
        Status status = world_.agree_on([&]() -> Status {
            best_.resize(rays_.size());
            last_.resize(rays_.size());
            pending_.resize(rays_.size());
            for (std::uint32_t i = 0; i < pending_.size(); ++i) pending_[i] = i;
            return {};
        });
        for (std::size_t most = 1; status; most *= 2) {
            status = world_.agree_on([&]() -> Status {
                choose_ranks(most);
                return {};
            });
            if (!status || world_.sum(pending_.size()) == 0) break;
            status = ask();
        }
        if (!status) return tl::unexpected(status.error());
        return std::move(best_);
    }

private:
    /// Has each ray ask the next ranks, so many at most; forgets rays that need none.
    void choose_ranks(std::size_t most)
    {
        for (auto& list : asked_) list.clear();
        std::vector<std::uint32_t> still;
        std::vector<Entry> entries;
        for (const std::uint32_t i : pending_) {
            entries.clear();
            for (std::uint32_t r = 0; r < asked_.size(); ++r) {
                const auto t = first_t(rays_[i], part_.boxes[r]);
                if (!t || *t > best_[i].t) continue;
                const Entry entry{*t, r};
                if (!last_[i] || *last_[i] < entry) entries.push_back(entry);
            }
            if (entries.empty()) continue;
            const std::size_t count = std::min(most, entries.size());
            std::partial_sort(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(count),
                              entries.end());
            for (std::size_t k = 0; k < count; ++k) asked_[entries[k].rank].push_back(i);
            last_[i] = entries[count - 1];
            still.push_back(i);
        }
        pending_ = std::move(still);
    }

    Status ask()
    {
        return ask_ranks(
            asked_,
            [&](std::uint32_t i) -> RayQuestion {
                const Ray& ray = rays_[i];
                return {{ray.origin[0], ray.origin[1], ray.origin[2]},
                        {ray.direction[0], ray.direction[1], ray.direction[2]},
                        ray.t_min,
                        std::min(ray.t_max, best_[i].t)};
            },
            [&](std::span<const RayQuestion> questions) { return answer_rays(part_, questions); },
            [&](std::uint32_t i, const HitOfWhole& answer) {
                if (answer.before(best_[i])) best_[i] = answer;
            },
            world_);
    }

    const MeshPart& part_;
    std::span<const Ray> rays_;
    World& world_;
    AskedRanks asked_;
    std::vector<HitOfWhole> best_;
    std::vector<std::optional<Entry>> last_; ///< the last rank asked of each ray
    std::vector<std::uint32_t> pending_;
};

} // namespace

Result<std::vector<HitOfWhole>> hits_over_ranks(const MeshPart& part, std::span<const Ray> rays,
                                                World& world)
{
    return RayRounds(part, rays, world).run();
}

} // namespace proxima
