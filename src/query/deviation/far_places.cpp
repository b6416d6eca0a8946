#include "query/deviation/far_places.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "query/deviation/measured_part.h"

#include <algorithm>
#include <tuple>

namespace proxima {

namespace {

bool is_farther(const FarPoint& one, const FarPoint& other) noexcept
{
    const auto key = [](const FarPoint& p) {
        return std::tuple(-p.nearest.distance, p.row_a, p.point.x(), p.point.y(), p.point.z());
    };
    return key(one) < key(other);
}

/// The far points of one triangle after the other.
class FarSearch {
public:
    FarSearch(const SurfacePair& pair, const MeasuredVertices& vertices,
              const FarPointLimits& limits, std::uint64_t bytes)
        : pair_(pair), vertices_(vertices), limits_(limits), pieces_(pair, limits.tolerance, bytes)
    {}

    void add_triangle(std::uint32_t row, const FarPoints& known, FarPoints& found)
    {
        const BoundedPart whole = bounded_triangle(pair_, vertices_, row);
        if (known.cover(whole.part.corners, limits_.spacing)) return;
        for (std::size_t k = 0; k < 3; ++k)
            offer({whole.part.corners[k], whole.part.nearest[k], row}, found);
        parts_.assign(1, whole);
        while (!parts_.empty()) {
            const BoundedPart part = parts_.back();
            parts_.pop_back();
            if (part.upper < limits_.certain || found.cover(part.part.corners, limits_.spacing))
                continue;
            if (!found.are_all) return;
            if (found.splits >= limits_.most_splits) {
                found.are_all = false;
                return;
            }
            NearPiece piece;
            if (pieces_.start(part.part, piece)) {
                search_pieces({piece, std::min(part.upper, pieces_.upper(piece))}, row, found);
            } else {
                halve(part, found);
            }
        }
    }

private:
    struct BoundedPiece {
        NearPiece piece;
        double upper = 0;
    };

    void offer(const FarPoint& point, FarPoints& found) const
    {
        if (point.nearest.distance >= limits_.enough) found.offer(point, limits_);
    }

    void halve(const BoundedPart& part, FarPoints& found)
    {
        const MeasuredPart::Halves halves = part.part.halves(pair_);
        ++found.splits;
        offer({halves.corner, halves.nearest, part.row_a}, found);
        for (const MeasuredPart& half : halves.parts) {
            parts_.push_back(bounded_part(pair_, half, part.row_a));
            parts_.back().upper = std::min(parts_.back().upper, part.upper);
        }
    }

    void search_pieces(const BoundedPiece& whole, std::uint32_t row, FarPoints& found)
    {
        heap_.assign(1, whole);
        while (!heap_.empty() && !(heap_.front().upper < limits_.certain)) {
            if (!found.are_all || found.splits >= limits_.most_splits || pieces_.is_full()) break;
            std::ranges::pop_heap(heap_, HasLowerBound());
            const auto [piece, upper] = heap_.back();
            heap_.pop_back();
            if (found.cover(pieces_.part(piece).corners, limits_.spacing)) continue;
            const auto [parts, corner] = pieces_.split(piece);
            ++found.splits;
            offer_corner(pieces_.part(parts[0]), corner, row, found);
            for (const NearPiece& part : parts) {
                heap_.push_back({part, std::min(pieces_.upper(part), upper)});
                std::ranges::push_heap(heap_, HasLowerBound());
            }
        }
        for (const auto& [piece, upper] : heap_) {
            if (!(upper < limits_.certain)) parts_.push_back({pieces_.part(piece), row, upper});
        }
    }

    void offer_corner(const MeasuredPart& part, std::size_t corner, std::uint32_t row,
                      FarPoints& found) const
    {
        const double distance = part.nearest[corner].distance;
        if (!(distance >= limits_.enough)) return;
        const Vec3& point = part.corners[corner];
        offer({point, pair_.nearest(point, distance), row}, found);
    }

    const SurfacePair& pair_;
    const MeasuredVertices& vertices_;
    const FarPointLimits& limits_;
    NearPieces pieces_;
    std::vector<BoundedPart> parts_;
    std::vector<BoundedPiece> heap_;
};

} // namespace

FarPlace far_place(const SurfacePair& pair, const FarPoint& far) noexcept
{
    const std::uint32_t row_b = far.nearest.row;
    return {.distance = pair.from_units(far.nearest.distance),
            .point_a = pair.from_units(far.point),
            .point_b = pair.from_units(closest_point(pair.b().triangle(row_b), far.point).point),
            .triangle_a = pair.a().id(far.row_a),
            .triangle_b = pair.b().id(row_b)};
}

void FarPoints::offer(const FarPoint& point, const FarPointLimits& limits)
{
    const double squared = limits.spacing * limits.spacing;
    for (const FarPoint& other : points)
        if ((other.point - point.point).squaredNorm() <= squared) return;
    if (points.size() < limits.most_points) {
        points.push_back(point);
    } else {
        are_all = false;
    }
}

bool FarPoints::cover(const std::array<Vec3, 3>& corners, double spacing) const noexcept
{
    // Farther than two points may be from each other, so that cuts come to an end.
    const double reach = 1.5 * spacing;
    return std::ranges::any_of(points, [&](const FarPoint& far) {
        return std::ranges::all_of(corners, [&](const Vec3& corner) {
            return (corner - far.point).squaredNorm() <= reach * reach;
        });
    });
}

Result<FarPoints> far_points(const SurfacePair& pair, const MeasuredVertices& vertices,
                             std::span<const std::uint32_t> rows, const FarPoint& first,
                             const FarPointLimits& limits, const Execution& execution)
{
    FarPoints all;
    all.offer(first, limits);
    constexpr std::size_t batch = 1024;
    constexpr std::size_t chunk = 8;
    const std::uint64_t budget = budget_bytes(execution.budget) / 4;
    const std::uint64_t bytes = std::min(budget, NearPieces::most_bytes);
    begin_stage(execution.progress, "places that are as far", rows.size());
    for (std::size_t start = 0; start < rows.size() && all.are_all; start += batch) {
        const std::span<const std::uint32_t> some =
            rows.subspan(start, std::min(batch, rows.size() - start));
        std::vector<FarPoints> found(some.size());
        parallel_chunks(some.size(), chunk, at_most(execution.threads, budget / bytes),
                        [&](std::size_t begin, std::size_t end) {
                            FarSearch search(pair, vertices, limits, bytes);
                            for (std::size_t i = begin; i < end; ++i) {
                                if (is_cancelled(execution.progress)) return;
                                search.add_triangle(some[i], all, found[i]);
                            }
                            advance_stage(execution.progress, end - begin);
                        });
        if (is_cancelled(execution.progress)) return cancelled("finding the farthest places");
        std::vector<FarPoint> points;
        for (const FarPoints& of_triangle : found) {
            points.insert(points.end(), of_triangle.points.begin(), of_triangle.points.end());
            all.are_all = all.are_all && of_triangle.are_all;
            all.splits += of_triangle.splits;
        }
        std::ranges::sort(points, is_farther);
        for (const FarPoint& point : points) all.offer(point, limits);
    }
    std::ranges::sort(all.points, is_farther);
    return all;
}

} // namespace proxima
