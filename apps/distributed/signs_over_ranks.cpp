#include "distributed/signs_over_ranks.h"

#include "distributed/ask_ranks.h"
#include "index/crossings.h"

#include <array>
#include <cmath>

namespace proxima {

namespace {

/// Whether the ray along x from the point may cross a triangle in the box.
bool may_cross(const Box& box, const Vec3& p) noexcept
{
    return !box.empty() && box.lower.y() <= p.y() && p.y() <= box.upper.y() &&
           box.lower.z() <= p.z() && p.z() <= box.upper.z() && p.x() <= box.upper.x();
}

std::vector<std::int64_t> count_crossings(const MeshPart& part,
                                          std::span<const std::array<double, 3>> points)
{
    std::vector<std::int64_t> counts;
    counts.reserve(points.size());
    for (const auto& point : points) {
        std::int64_t& count = counts.emplace_back();
        visit_crossings(part.index.parts(), part.whole_box, {}, Vec3(point.data()),
                        [&](std::uint32_t /*row*/, int crossing) { count += crossing; });
    }
    return counts;
}

} // namespace

Status check_closed(const MeshPart& part)
{
    if (part.unbalanced_edges == 0) return {};
    return fail(ErrorCode::invalid_mesh,
                concat("the mesh is open, or not oriented alike, at ", part.unbalanced_edges,
                       " edges: proxima-mpi signs closed meshes alone; close it by proxima repair, "
                       "or ask proxima closest --signed"));
}

Result<std::vector<SignedOfWhole>> signs_over_ranks(const MeshPart& part,
                                                    std::span<const Vec3> points, World& world)
{
    const auto closest = closest_over_ranks(part, points, world);
    if (!closest) return tl::unexpected(closest.error());
    std::vector<SignedOfWhole> answers;
    AskedRanks asked(static_cast<std::size_t>(world.size()));
    Status status = world.agree_on([&]() -> Status {
        answers.reserve(points.size());
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            const ClosestOfWhole& feature = (*closest)[i];
            answers.push_back({feature});
            if (feature.is_on_feature != 0 || !part.whole_box.contains(points[i]) ||
                !std::isfinite(feature.distance(part.scale)))
                continue;
            for (std::size_t r = 0; r < asked.size(); ++r) {
                if (may_cross(part.boxes[r], points[i])) asked[r].push_back(i);
            }
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    status = ask_ranks(
        asked,
        [&](std::uint32_t i) {
            return std::array<double, 3>{points[i][0], points[i][1], points[i][2]};
        },
        [&](std::span<const std::array<double, 3>> questions) {
            return count_crossings(part, questions);
        },
        [&](std::uint32_t i, std::int64_t crossings) { answers[i].winding += crossings; }, world);
    if (!status) return tl::unexpected(status.error());
    return answers;
}

} // namespace proxima
