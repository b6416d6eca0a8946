#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "proxima/mesh_deviation.h"
#include "query/deviation/far_places.h"
#include "query/deviation/measured_part.h"
#include "query/deviation/part_search.h"
#include "query/deviation/row_cover.h"
#include "query/deviation/surface_pair.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

class GreatestSearch {
public:
    GreatestSearch(const SurfacePair& pair, const MeasuredVertices& vertices,
                   const GreatestDeviationOptions& options, double tolerance)
        : pair_(pair), vertices_(vertices), options_(options),
          tolerance_(std::max(tolerance - 2 * most_rounding(pair), 2 * most_rounding(pair)))
    {}

    Status run()
    {
        Progress* const progress = options_.execution.progress;
        bound_triangles();
        if (is_cancelled(progress)) return stopped();
        if (!order_.empty()) neighbors_ = RowNeighbors(pair_.b());
        begin_stage(progress, "triangles along the other surface", order_.size());
        cover_triangles();
        if (is_cancelled(progress)) return stopped();
        begin_stage(progress, "triangles that may be farthest", order_.size());
        for (std::size_t first = 0, batch = 64; first < order_.size();) {
            // In order of their bounds: the first that is settled settles all after it.
            const std::size_t count = limited(std::min(batch, order_.size() - first));
            if (count == 0) break;
            search(count, [&](std::size_t i, PartSearch& parts, PartOutcome& outcome) {
                const std::uint32_t row = order_[first + i];
                parts.search_triangle(vertices_, row, uppers_[row], outcome);
            });
            if (is_cancelled(progress)) return stopped();
            advance_stage(progress, count);
            first += count;
            done_ = first;
            batch = std::min<std::size_t>(2 * batch, 4096);
        }
        while (!pending_.empty()) {
            const std::size_t count = limited(std::max<std::size_t>(4096, pending_.size() / 4));
            if (count == 0) break;
            std::vector<BoundedPart> parts;
            take_pending(count, parts);
            begin_stage(progress, "parts that may be farthest", parts.size());
            search(parts.size(), [&](std::size_t i, PartSearch& one, PartOutcome& outcome) {
                one.search_part(parts[i], outcome);
                advance_stage(progress, 1);
            });
            if (is_cancelled(progress)) return stopped();
        }
        return {};
    }

    [[nodiscard]] GreatestDeviation answer() const
    {
        SettledBound all = settled_;
        for (const BoundedPart& some : pending_) all.add(some.upper, some.part.cuts);
        for (std::size_t i = done_; i < order_.size(); ++i) all.add(uppers_[order_[i]], 0);
        GreatestDeviation result;
        const double measured = greatest();
        const double lower = std::max(measured - pair_.rounding(farthest_.cuts), 0.0);
        const double upper = std::max(all.upper, measured) + pair_.rounding(all.cuts);
        const bool is_zero = all.is_zero;
        if (!is_zero) result.distance = pair_.from_units(DistanceBounds{lower, upper});
        const FarPlace place = far_place(pair_, farthest_point());
        result.point_a = place.point_a;
        result.point_b = place.point_b;
        result.triangle_a = place.triangle_a;
        result.triangle_b = place.triangle_b;
        result.splits = splits_;
        return result;
    }

    /// All places that are as far, after run().
    Status find_places(GreatestDeviation& result) const
    {
        if (result.distance.upper == 0) {
            result.has_all_places = true;
            return {};
        }
        const double certain = greatest() - 2 * most_rounding(pair_);
        std::vector<std::uint32_t> rows;
        for (std::uint32_t row = 0; row < uppers_.size(); ++row)
            if (uppers_[row] != 0 && uppers_[row] >= certain) rows.push_back(row);
        if (rows.empty()) { // on meshes of denormal size, whose distances are what doubles round by
            result.places.push_back(far_place(pair_, farthest_point()));
            return {};
        }
        const double spacing = options_.place_spacing > 0
                                   ? pair_.to_units(options_.place_spacing)
                                   : GreatestDeviationOptions::default_spacing * pair_.diagonal();
        const auto found = far_points(
            pair_, vertices_, rows, farthest_point(),
            {.enough = greatest() - tolerance_,
             .certain = certain,
             .spacing = spacing,
             .most_points = options_.max_places,
             .most_splits = std::max<std::uint64_t>(options_.max_splits / rows.size(), 64),
             .tolerance = tolerance_},
            options_.execution);
        if (!found) return tl::unexpected(found.error());
        for (const FarPoint& point : found->points)
            result.places.push_back(far_place(pair_, point));
        result.has_all_places = found->are_all;
        result.splits += found->splits;
        return {};
    }

private:
    [[nodiscard]] FarPoint farthest_point() const noexcept
    {
        return {farthest_.point, farthest_.nearest, farthest_.row_a};
    }
    [[nodiscard]] double greatest() const noexcept { return farthest_.nearest.distance; }

    static constexpr std::uint64_t most_local_splits = 1024;

    static double most_rounding(const SurfacePair& pair) noexcept
    {
        return pair.rounding(PartSearch::most_cuts);
    }

    static tl::unexpected<Error> stopped() { return cancelled("measuring the greatest deviation"); }

    [[nodiscard]] double limit() const noexcept { return greatest() + tolerance_; }

    /// How many of so many pieces may be searched together, so that neither max_splits nor the memory
    /// is overrun, whatever each of them becomes; sets local_splits_. 0 where there is too little left.
    std::size_t limited(std::size_t wanted)
    {
        // Lists that grow take up to three times their size.
        const std::uint64_t all =
            budget_bytes(options_.execution.budget) / (8 * sizeof(BoundedPart));
        const std::uint64_t room = all > pending_.size() ? all - pending_.size() : 0;
        const std::uint64_t splits =
            options_.max_splits > splits_ ? options_.max_splits - splits_ : 0;
        if (room < std::max<std::uint64_t>(all / 16, 3) || splits == 0) return 0;
        local_splits_ = std::min({most_local_splits, splits, room - 1});
        return std::min<std::uint64_t>(
            {wanted, splits / local_splits_, room / (local_splits_ + 1)});
    }

    /// Bounds of all triangles by their vertices alone, and those that are not settled by their bounds.
    void bound_triangles()
    {
        const std::uint32_t count = pair_.a().triangle_count();
        constexpr std::size_t chunk = 1024;
        std::vector<FarthestPoint> farthest(chunk_count(count, chunk));
        parallel_chunks(count, chunk, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(options_.execution.progress)) return;
                            for (std::size_t i = first; i < end; ++i)
                                offer_corners(i, farthest[first / chunk]);
                        });
        if (is_cancelled(options_.execution.progress)) return;
        for (const FarthestPoint& some : farthest) farthest_.offer(some);
        uppers_.resize(count);
        parallel_chunks(
            count, chunk, options_.execution.threads, [&](std::size_t first, std::size_t end) {
                if (is_cancelled(options_.execution.progress)) return;
                for (std::size_t i = first; i < end; ++i) {
                    const BoundedPart whole =
                        bounded_triangle(pair_, vertices_, static_cast<std::uint32_t>(i));
                    uppers_[i] = is_of_b(whole.part) ? 0 : raised(whole.upper);
                }
            });
        for (std::uint32_t row = 0; row < count; ++row) {
            if (uppers_[row] == 0) continue;
            if (uppers_[row] > limit()) {
                order_.push_back(row);
            } else {
                settled_.add(uppers_[row], 0);
            }
        }
    }

    /// Whether a triangle is one of B as well.
    [[nodiscard]] bool is_of_b(const MeasuredPart& whole) const noexcept
    {
        if (std::ranges::any_of(whole.nearest,
                                [](const NearestRow& nearest) { return nearest.distance > 0; }))
            return false;
        const auto is_it = [&](std::uint32_t row) {
            return is_row_of_b(pair_, whole.corners, row);
        };
        if (std::ranges::any_of(whole.nearest, is_it, &NearestRow::row)) return true;
        // The rows of its corners may be others that they share.
        const auto& [p, q, r] = whole.corners;
        const Vec3 centroid = (p + q + r) / 3;
        return is_it(pair_.nearest(centroid, whole.reach(centroid)).row);
    }

    /// Lowers the bounds of triangles that B lies along, and puts the largest first.
    void cover_triangles()
    {
        constexpr std::size_t chunk = 256;
        std::vector<PartOutcome> outcomes(chunk_count(order_.size(), chunk));
        const std::uint64_t most_threads =
            budget_bytes(options_.execution.budget) / (4 * RowCover::most_bytes);
        parallel_chunks(order_.size(), chunk, at_most(options_.execution.threads, most_threads),
                        [&](std::size_t first, std::size_t end) {
                            PartSearch search(pair_, neighbors_, tolerance_, greatest(), 0, 0);
                            for (std::size_t i = first; i < end; ++i) {
                                if (is_cancelled(options_.execution.progress)) return;
                                cover(order_[i], search, outcomes[first / chunk]);
                            }
                            advance_stage(options_.execution.progress, end - first);
                        });
        if (is_cancelled(options_.execution.progress)) return;
        for (const PartOutcome& outcome : outcomes) {
            farthest_.offer(outcome.farthest);
            settled_.allow(outcome.settled.cuts);
        }
        std::size_t left = 0;
        for (const std::uint32_t row : order_) {
            if (uppers_[row] > limit()) {
                order_[left++] = row;
            } else {
                settled_.add(uppers_[row], 0);
            }
        }
        order_.resize(left);
        std::ranges::stable_sort(
            order_, [&](std::uint32_t a, std::uint32_t b) { return uppers_[a] > uppers_[b]; });
    }

    void cover(std::uint32_t row, PartSearch& search, PartOutcome& outcome)
    {
        BoundedPart whole{.part = {.corners = pair_.a().triangle(row).vertices,
                                   .nearest = vertices_.of_row(pair_.a(), row)},
                          .row_a = row,
                          .upper = uppers_[row]};
        search.cover(whole, outcome);
        uppers_[row] = raised(whole.upper);
    }

    void offer_corners(std::size_t i, FarthestPoint& farthest) const
    {
        const auto row = static_cast<std::uint32_t>(i);
        const Triangle triangle = pair_.a().triangle(row);
        const auto nearest = vertices_.of_row(pair_.a(), row);
        for (std::size_t k = 0; k < 3; ++k)
            farthest.offer(nearest[k], triangle.vertices[k], row, 0);
    }

    /// Never 0, which stands for a triangle of B.
    static double raised(double upper) noexcept { return std::max(upper, 1e-300); }

    template <class Search>
    void search(std::size_t count, const Search& search_one)
    {
        constexpr std::size_t chunk = 8;
        std::vector<PartOutcome> outcomes(count);
        // Neither the bytes of a search nor what it finds depend on the number of threads.
        const std::uint64_t all = budget_bytes(options_.execution.budget) / 4;
        const std::uint64_t bytes = std::min(all, NearPieces::most_bytes);
        parallel_chunks(count, chunk, at_most(options_.execution.threads, all / bytes),
                        [&](std::size_t first, std::size_t end) {
                            PartSearch search(pair_, neighbors_, tolerance_, greatest(),
                                              local_splits_, bytes);
                            for (std::size_t i = first; i < end; ++i) {
                                if (is_cancelled(options_.execution.progress)) return;
                                search_one(i, search, outcomes[i]);
                            }
                        });
        // In the order of the parts, whatever thread was first.
        for (PartOutcome& outcome : outcomes) {
            farthest_.offer(outcome.farthest);
            settled_.add(outcome.settled);
            splits_ += outcome.splits;
        }
        for (PartOutcome& outcome : outcomes) {
            for (BoundedPart& some : outcome.left) {
                if (some.upper > limit()) {
                    pending_.push_back(some);
                } else {
                    settled_.add(some.upper, some.part.cuts);
                }
            }
        }
    }

    /// Some of the largest bounds among all that is pending, and drops what is settled by now.
    void take_pending(std::size_t most, std::vector<BoundedPart>& parts)
    {
        std::erase_if(pending_, [&](const BoundedPart& some) {
            if (some.upper > limit()) return false;
            settled_.add(some.upper, some.part.cuts);
            return true;
        });
        const std::size_t count = std::min(most, pending_.size());
        const auto first = pending_.end() - static_cast<std::ptrdiff_t>(count);
        if (first != pending_.end()) std::ranges::nth_element(pending_, first, HasLowerBound());
        parts.assign(first, pending_.end());
        pending_.erase(first, pending_.end());
    }

    const SurfacePair& pair_;
    const MeasuredVertices& vertices_;
    const GreatestDeviationOptions& options_;
    RowNeighbors neighbors_;
    double tolerance_;
    FarthestPoint farthest_;
    SettledBound settled_;
    std::vector<double> uppers_; ///< by row; 0 for triangles of B
    std::vector<std::uint32_t> order_;
    std::size_t done_ = 0; ///< of order_
    std::vector<BoundedPart> pending_;
    std::uint64_t splits_ = 0;
    std::uint64_t local_splits_ = most_local_splits; ///< of one piece at a time
};

Status check_options(const GreatestDeviationOptions& options)
{
    const auto bad = [](std::string what, const char* where) {
        return fail(ErrorCode::invalid_argument, std::move(what), where);
    };
    if (!(options.tolerance >= 0)) return bad("the tolerance is no number from 0 up", "tolerance");
    if (!(options.place_spacing >= 0))
        return bad("the spacing is no number from 0 up", "place_spacing");
    if (options.max_places > max_deviation_places)
        return bad(concat("more than ", max_deviation_places, " places"), "max_places");
    return {};
}

} // namespace

Result<GreatestDeviation> greatest_deviation(const MeshIndex& a, const MeshIndex& b,
                                             const GreatestDeviationOptions& options)
{
    if (Status status = check_options(options); !status) return tl::unexpected(status.error());
    const auto pair = SurfacePair::make(a, b, options.execution);
    if (!pair) return tl::unexpected(pair.error());
    if (Status status = check_budget(
            options.execution.budget, pair->bytes() + RowNeighbors::bytes_of(pair->b()),
            "measuring the greatest deviation", "raise the budget or measure parts of the mesh");
        !status)
        return tl::unexpected(status.error());
    const double tolerance = options.tolerance > 0
                                 ? pair->to_units(options.tolerance)
                                 : GreatestDeviationOptions::default_tolerance * pair->diagonal();
    const auto vertices = measure_vertices(*pair, options.execution);
    if (!vertices) return tl::unexpected(vertices.error());
    GreatestSearch search(*pair, *vertices, options, tolerance);
    if (Status status = search.run(); !status) return tl::unexpected(status.error());
    GreatestDeviation result = search.answer();
    result.is_complete = pair->to_units(result.distance.upper - result.distance.lower) <= tolerance;
    if (options.max_places == 0) return result;
    if (Status status = search.find_places(result); !status) return tl::unexpected(status.error());
    return result;
}

} // namespace proxima
