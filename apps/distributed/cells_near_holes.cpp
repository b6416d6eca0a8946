#include "distributed/cells_near_holes.h"

#include "octree/winding_number.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace proxima {

namespace {

using Point = std::array<double, 3>;

enum class Side : std::uint8_t { open, outside, inside };

/// The triangles that count here: each of the whole mesh counts on one rank.
Result<TriangleMesh> counted_mesh(const RoutedPart& part)
{
    std::vector<TriangleCorners> corners;
    for (std::size_t i = 0; i < part.mesh.triangle_count(); ++i) {
        if (part.is_counted[i]) corners.push_back(part.mesh.triangles()[i]);
    }
    const auto positions = part.mesh.positions();
    return make_triangle_mesh({positions.begin(), positions.end()}, std::move(corners));
}

/// A block of points of all ranks.
class Decider {
public:
    Decider(const WindingNumber* winding, World& world) : winding_(winding), world_(world) {}

    Result<std::vector<Side>> decide(const std::vector<Point>& points)
    {
        sides_.assign(points.size(), Side::open);
        for (double tolerance = 0.006;; tolerance /= 16.0) {
            std::vector<std::size_t> left;
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (sides_[i] == Side::open) left.push_back(i);
            }
            if (left.empty()) return std::move(sides_);
            const bool is_last = tolerance <= winding::rounding_error;
            std::vector<double> sums(2 * left.size()); // values and errors
            Status status = world_.agree_on(
                [&] { return estimate(points, left, is_last ? 0.0 : tolerance, sums); });
            if (!status) return tl::unexpected(status.error());
            world_.sum(sums);
            for (std::size_t k = 0; k < left.size(); ++k) {
                const double above = sums[2 * k] - winding::inside_limit;
                const double doubt = is_last ? 0x1p-42 : sums[2 * k + 1];
                if (std::abs(above) > doubt) {
                    sides_[left[k]] = above > 0 ? Side::inside : Side::outside;
                } else if (is_last) {
                    return undecided(points[left[k]]);
                }
            }
        }
    }

private:
    Status estimate(const std::vector<Point>& points, const std::vector<std::size_t>& left,
                    double tolerance, std::vector<double>& sums)
    {
        if (winding_ == nullptr) return {};
        const TriangleMesh& mesh = winding_->mesh();
        const auto triangle_at = [&mesh](std::uint32_t id) {
            return mesh.triangle(TriangleId{id});
        };
        StageSteps steps(&world_.progress(), "cells near holes", left.size(), 16);
        for (std::size_t k = 0; k < left.size(); ++k) {
            const Point& point = points[left[k]];
            const WindingEstimate found = winding::estimate(
                winding_->clusters(), triangle_at, {point[0], point[1], point[2]}, tolerance);
            sums[2 * k] = found.value;
            sums[2 * k + 1] = found.error;
            if (!steps.done(1)) return cancelled("classifying cells");
        }
        return {};
    }

    static tl::unexpected<Error> undecided(const Point& point)
    {
        return fail(ErrorCode::limit_exceeded,
                    concat("near a hole, at (", point[0], ", ", point[1], ", ", point[2],
                           "), the winding number is too near 1/2 to say on several ranks "
                           "whether the cell is inside: use proxima octree, or close the hole"));
    }

    const WindingNumber* winding_;
    World& world_;
    std::vector<Side> sides_;
};

} // namespace

Result<std::vector<bool>> inside_near_holes(const RoutedPart& part, const std::vector<Vec3>& points,
                                            World& world)
{
    constexpr std::size_t block = 1U << 16U;
    const std::uint64_t rounds = (world.max(points.size()) + block - 1) / block;
    std::vector<bool> is_inside;
    if (rounds == 0) return is_inside;
    TriangleMesh mesh;
    std::optional<WindingNumber> winding;
    const Status status = world.agree_on([&]() -> Status {
        auto counted = counted_mesh(part);
        if (!counted) return tl::unexpected(counted.error());
        mesh = std::move(*counted);
        if (mesh.triangle_count() == 0) return {};
        auto built = build_winding_number(mesh, {{.threads = {1}, .progress = &world.progress()}});
        if (!built) return tl::unexpected(built.error());
        winding = std::move(*built);
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    Decider decider(winding ? &*winding : nullptr, world);
    for (std::uint64_t round = 0; round < rounds; ++round) {
        std::vector<Point> own;
        for (std::size_t i = round * block; i < std::min(points.size(), (round + 1) * block); ++i) {
            own.push_back({points[i][0], points[i][1], points[i][2]});
        }
        const auto all = world.all_gather(own);
        if (!all) return tl::unexpected(all.error());
        const auto sides = decider.decide(all->items);
        if (!sides) return tl::unexpected(sides.error());
        const std::size_t first = all->first[static_cast<std::size_t>(world.rank())];
        for (std::size_t i = 0; i < own.size(); ++i) {
            is_inside.push_back((*sides)[first + i] == Side::inside);
        }
    }
    return is_inside;
}

} // namespace proxima
