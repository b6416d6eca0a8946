#include "distributed/signs_over_ranks.h"

#include "distributed/ask_ranks.h"
#include "index/crossings.h"
#include "index/index_parts.h"
#include "octree/winding_clusters.h"

#include <array>
#include <cmath>

namespace proxima {

namespace {

using Position = std::array<double, 3>;

Position position_of(const Vec3& p) noexcept
{
    return {p[0], p[1], p[2]};
}

/// Whether the ray along x from the point may cross a triangle in the box.
bool may_cross(const Box& box, const Vec3& p) noexcept
{
    return !box.empty() && box.lower.y() <= p.y() && p.y() <= box.upper.y() &&
           box.lower.z() <= p.z() && p.z() <= box.upper.z() && p.x() <= box.upper.x();
}

std::vector<std::int64_t> count_crossings(const MeshPart& part, std::span<const Position> points)
{
    std::vector<std::int64_t> counts;
    counts.reserve(points.size());
    for (const Position& point : points) {
        std::int64_t& count = counts.emplace_back();
        visit_crossings(part.index.parts(), part.whole_box, {}, Vec3(point.data()),
                        [&](std::uint32_t /*row*/, int crossing) { count += crossing; });
    }
    return counts;
}

std::vector<WindingEstimate> estimate_winding(const MeshPart& part,
                                              std::span<const Position> points, double tolerance)
{
    const IndexParts& index = part.index.parts();
    std::vector<WindingEstimate> estimates;
    estimates.reserve(points.size());
    for (const Position& point : points) {
        estimates.push_back(winding::estimate(
            part.winding.view(), [&](std::uint32_t row) { return index.triangle(row); },
            Vec3(point.data()), tolerance));
    }
    return estimates;
}

/// A distance, in units of the frame, beyond which no point is inside. A ball of radius r, seen from
/// the distance d of its middle, is less than r^2 / (2 d^2) of all directions, and so is each of the n
/// triangles in it: from sqrt(2 n) r on, all of them wind less than 1/4 around a point.
double reach_of_inside(const MeshPart& part) noexcept
{
    const double radius = (part.whole_box.extent() * part.scale).norm() / 2;
    return std::sqrt(2 * static_cast<double>(part.whole_triangles)) * radius;
}

class SignRun {
public:
    SignRun(const MeshPart& part, std::span<const Vec3> points, std::uint64_t first, World& world)
        : part_(part), points_(points), first_(first), world_(world), reach_(reach_of_inside(part)),
          asked_(static_cast<std::size_t>(world.size()))
    {}

    Result<std::vector<SignedOfWhole>> run()
    {
        const auto closest = closest_over_ranks(part_, points_, world_);
        if (!closest) return tl::unexpected(closest.error());
        Status status = world_.agree_on([&]() -> Status {
            answers_.reserve(points_.size());
            for (const ClosestOfWhole& feature : *closest) answers_.push_back({feature});
            return {};
        });
        if (status) status = part_.is_closed() ? count() : bound();
        if (!status) return tl::unexpected(status.error());
        return std::move(answers_);
    }

private:
    /// Whether a point has no other sign to be told: where squares overflow, the mesh is a dot.
    [[nodiscard]] bool is_told(std::uint32_t i) const noexcept
    {
        const ClosestOfWhole& closest = answers_[i].closest;
        return closest.is_on_feature != 0 || !std::isfinite(closest.distance(part_.scale));
    }

    /// Whether the point has no winding number of 1/2. Sums would overflow far away.
    [[nodiscard]] bool is_far(std::uint32_t i) const noexcept
    {
        const Vec3 from_middle = (points_[i] - part_.whole_box.center()) * part_.scale;
        return from_middle.norm() > reach_;
    }

    Status count()
    {
        Status status = world_.agree_on([&]() -> Status {
            for (std::uint32_t i = 0; i < points_.size(); ++i) {
                if (is_told(i) || !part_.whole_box.contains(points_[i])) continue;
                for (std::size_t r = 0; r < asked_.size(); ++r) {
                    if (may_cross(part_.boxes[r], points_[i])) asked_[r].push_back(i);
                }
            }
            return {};
        });
        if (!status) return status;
        return ask_ranks(
            asked_, [&](std::uint32_t i) { return position_of(points_[i]); },
            [&](std::span<const Position> points) { return count_crossings(part_, points); },
            [&](std::uint32_t i, std::int64_t crossings) { answers_[i].winding += crossings; },
            world_);
    }

    Status bound()
    {
        std::vector<std::uint32_t> pending;
        Status status = world_.agree_on([&]() -> Status {
            for (std::uint32_t i = 0; i < points_.size(); ++i)
                if (!is_told(i) && !is_far(i)) pending.push_back(i);
            return {};
        });
        // The steps of winding::exceeds.
        double tolerance = 0.006;
        while (status && tolerance > winding::rounding_error) {
            if (world_.sum(pending.size()) == 0) return {};
            status = sharpen(tolerance, pending);
            tolerance /= 16.0;
        }
        if (status) status = sharpen(0, pending);
        if (!status) return status;
        return world_.agree_on([&]() -> Status {
            if (pending.empty()) return {};
            return fail(ErrorCode::limit_exceeded,
                        concat("the mesh is open, and whether point ", first_ + pending.front(),
                               " is inside hangs on rounding: move it a little, or close the mesh "
                               "by proxima repair"));
        });
    }

    /// Asks all ranks about points, and leaves those that are not decided.
    Status sharpen(double tolerance, std::vector<std::uint32_t>& pending)
    {
        // Where all triangles are summed nothing but rounding is left.
        constexpr double summing_error = 0x1p-42;
        std::vector<WindingEstimate> sums;
        Status status = world_.agree_on([&]() -> Status {
            sums.resize(points_.size());
            for (std::size_t r = 0; r < asked_.size(); ++r) {
                asked_[r].clear();
                if (!part_.boxes[r].empty()) asked_[r] = pending;
            }
            return {};
        });
        if (!status) return status;
        status = ask_ranks(
            asked_, [&](std::uint32_t i) { return position_of(points_[i]); },
            [&](std::span<const Position> points) {
                return estimate_winding(part_, points, tolerance);
            },
            [&](std::uint32_t i, const WindingEstimate& estimate) {
                sums[i].value += estimate.value;
                sums[i].error += estimate.error;
            },
            world_);
        if (!status) return status;
        std::erase_if(pending, [&](std::uint32_t i) {
            const double beyond = sums[i].value - winding::inside_limit;
            const double error = tolerance > 0 ? sums[i].error : summing_error;
            if (!(std::abs(beyond) > error)) return false;
            answers_[i].winding = beyond >= 0 ? 1 : 0;
            return true;
        });
        return {};
    }

    const MeshPart& part_;
    std::span<const Vec3> points_;
    std::uint64_t first_;
    World& world_;
    double reach_;
    AskedRanks asked_;
    std::vector<SignedOfWhole> answers_;
};

} // namespace

Result<std::vector<SignedOfWhole>> signs_over_ranks(const MeshPart& part,
                                                    std::span<const Vec3> points,
                                                    std::uint64_t first, World& world)
{
    return SignRun(part, points, first, world).run();
}

} // namespace proxima
