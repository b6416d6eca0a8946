#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "proxima/mesh_deviation.h"
#include "query/deviation/surface_pair.h"
#include "query/deviation/surface_piece.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

/// The point of A farthest from B that is known.
struct FarthestPoint {
    NearestRow nearest = {.distance = -1, .row = 0};
    Vec3 point = Vec3::Zero();
    std::uint32_t row_a = 0;
    std::uint32_t cuts = 0;

    void offer(const NearestRow& other, const Vec3& at, std::uint32_t row, std::uint32_t cut_count)
    {
        if (!(other.distance > nearest.distance)) return;
        *this = {.nearest = other, .point = at, .row_a = row, .cuts = cut_count};
    }
    void offer(const FarthestPoint& other)
    {
        if (other.nearest.distance > nearest.distance) *this = other;
    }
};

/// A bound of the distances of pieces that need no more cuts.
struct SettledBound {
    double upper = 0;
    std::uint32_t cuts = 0;
    bool is_zero = true; ///< all are triangles of B

    void add(double bound, std::uint32_t cut_count)
    {
        upper = std::max(upper, bound);
        cuts = std::max(cuts, cut_count);
        is_zero = false;
    }
    void add(const SettledBound& other)
    {
        upper = std::max(upper, other.upper);
        cuts = std::max(cuts, other.cuts);
        is_zero = is_zero && other.is_zero;
    }
};

/// What a few cuts of one piece gave.
struct PieceOutcome {
    FarthestPoint farthest;
    SettledBound settled;
    std::vector<SurfacePiece> left;
    std::uint64_t splits = 0;
};

bool is_lower(const SurfacePiece& one, const SurfacePiece& other) noexcept
{
    return one.upper() < other.upper();
}

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
        begin_stage(progress, "triangles that may be farthest", order_.size());
        for (std::size_t first = 0, batch = 64; first < order_.size();) {
            // In order of their bounds: the first that is settled settles all after it.
            const std::size_t count = limited(std::min(batch, order_.size() - first));
            if (count == 0) break;
            const std::size_t end = first + count;
            search(end - first, [&](std::size_t i, PieceOutcome& outcome) {
                search_triangle(order_[first + i], outcome);
            });
            if (is_cancelled(progress)) return stopped();
            advance_stage(progress, end - first);
            first = end;
            done_ = first;
            batch = std::min<std::size_t>(2 * batch, 4096);
        }
        while (!pending_.empty()) {
            const std::size_t count = limited(std::max<std::size_t>(4096, pending_.size() / 4));
            if (count == 0) break;
            std::vector<SurfacePiece> pieces;
            take_pending(count, pieces);
            begin_stage(progress, "parts that may be farthest", pieces.size());
            search(pieces.size(), [&](std::size_t i, PieceOutcome& outcome) {
                search_piece(pieces[i], outcome);
                advance_stage(progress, 1);
            });
            if (is_cancelled(progress)) return stopped();
        }
        return {};
    }

    [[nodiscard]] GreatestDeviation answer() const
    {
        SettledBound all = settled_;
        for (const SurfacePiece& piece : pending_) all.add(piece.upper(), piece.cuts());
        for (std::size_t i = done_; i < order_.size(); ++i) all.add(uppers_[order_[i]], 0);
        GreatestDeviation result;
        const double measured = farthest_.nearest.distance;
        const double lower = std::max(measured - pair_.rounding(farthest_.cuts), 0.0);
        const double upper = std::max(all.upper, measured) + pair_.rounding(all.cuts);
        const bool is_zero = all.is_zero;
        if (!is_zero) result.distance = pair_.from_units(DistanceBounds{lower, upper});
        result.point_a = pair_.from_units(farthest_.point);
        result.point_b = pair_.from_units(
            closest_point(pair_.b().triangle(farthest_.nearest.row), farthest_.point).point);
        result.triangle_a = pair_.a().id(farthest_.row_a);
        result.triangle_b = pair_.b().id(farthest_.nearest.row);
        result.splits = splits_;
        return result;
    }

private:
    static constexpr std::uint64_t most_local_splits = 64;

    static double most_rounding(const SurfacePair& pair) noexcept
    {
        return pair.rounding(SurfacePiece::most_cuts);
    }

    static tl::unexpected<Error> stopped() { return cancelled("measuring the greatest deviation"); }

    [[nodiscard]] double limit() const noexcept { return farthest_.nearest.distance + tolerance_; }

    /// How many of so many pieces may be searched together, so that neither max_splits nor the memory
    /// is overrun, whatever each of them becomes; sets local_splits_. 0 where there is too little left.
    std::size_t limited(std::size_t wanted)
    {
        // Lists that grow take up to three times their size.
        const std::uint64_t all =
            budget_bytes(options_.execution.budget) / (8 * sizeof(SurfacePiece));
        const std::uint64_t room = all > pending_.size() ? all - pending_.size() : 0;
        const std::uint64_t splits =
            options_.max_splits > splits_ ? options_.max_splits - splits_ : 0;
        if (room < std::max<std::uint64_t>(all / 16, 3) || splits == 0) return 0;
        local_splits_ = std::min({most_local_splits, splits, (room - 1) / 2});
        // A cut makes up to three pieces of one.
        return std::min<std::uint64_t>(
            {wanted, splits / local_splits_, room / (2 * local_splits_ + 1)});
    }

    /// Bounds of all triangles by their vertices alone, and those that are not settled by their
    /// bounds, the largest first.
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
        parallel_chunks(count, chunk, options_.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(options_.execution.progress)) return;
                            for (std::size_t i = first; i < end; ++i) {
                                const SurfacePiece piece = triangle_piece(i);
                                uppers_[i] = piece.is_of_b(pair_) ? 0 : raised(piece.upper());
                            }
                        });
        for (std::uint32_t row = 0; row < count; ++row) {
            if (uppers_[row] == 0) continue;
            if (uppers_[row] > limit() || farthest_.nearest.distance == 0) {
                order_.push_back(row);
            } else {
                settled_.add(uppers_[row], 0);
            }
        }
        std::ranges::stable_sort(
            order_, [&](std::uint32_t a, std::uint32_t b) { return uppers_[a] > uppers_[b]; });
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

    [[nodiscard]] SurfacePiece triangle_piece(std::size_t row) const
    {
        const auto row_a = static_cast<std::uint32_t>(row);
        return {pair_, row_a, vertices_.of_row(pair_.a(), row_a)};
    }

    template <class Search>
    void search(std::size_t count, const Search& search_one)
    {
        std::vector<PieceOutcome> outcomes(count);
        parallel_for(count, options_.execution.threads, [&](std::size_t i) {
            if (!is_cancelled(options_.execution.progress)) search_one(i, outcomes[i]);
        });
        // In the order of the pieces, whatever thread was first.
        for (PieceOutcome& outcome : outcomes) {
            farthest_.offer(outcome.farthest);
            settled_.add(outcome.settled);
            splits_ += outcome.splits;
        }
        for (PieceOutcome& outcome : outcomes) {
            for (SurfacePiece& piece : outcome.left) {
                if (piece.upper() > limit()) {
                    pending_.push_back(piece);
                } else {
                    settled_.add(piece.upper(), piece.cuts());
                }
            }
        }
    }

    void search_triangle(std::uint32_t row, PieceOutcome& outcome) const
    {
        const double upper = uppers_[row];
        if (!(upper > limit() || farthest_.nearest.distance == 0)) {
            outcome.settled.add(upper, 0);
            return;
        }
        SurfacePiece piece = triangle_piece(row);
        const Vec3 centroid = piece.centroid();
        const NearestRow nearest = pair_.nearest(centroid, piece.reach_of(centroid));
        outcome.farthest.offer(nearest, centroid, row, 1);
        piece.add_row(pair_, nearest.row);
        if (!piece.is_of_b(pair_)) search_piece(piece, outcome);
    }

    /// A few cuts, always of the part with the largest bound.
    void search_piece(const SurfacePiece& start, PieceOutcome& outcome) const
    {
        std::vector<SurfacePiece> heap = {start};
        std::vector<SurfacePiece> parts;
        const auto most = [&] {
            return std::max(farthest_.nearest.distance, outcome.farthest.nearest.distance) +
                   tolerance_;
        };
        for (std::uint64_t splits = 0; !heap.empty(); ++splits) {
            if (!(heap.front().upper() > most()) || splits == local_splits_) break;
            std::ranges::pop_heap(heap, is_lower);
            const SurfacePiece piece = heap.back();
            heap.pop_back();
            if (piece.cuts() >= SurfacePiece::most_cuts) {
                outcome.settled.add(piece.upper(), piece.cuts());
                continue;
            }
            parts.clear();
            const SurfacePiece::Cut cut = piece.split(pair_, 0.25 * tolerance_, parts);
            ++outcome.splits;
            outcome.farthest.offer(cut.nearest, cut.point, piece.row_a(), piece.cuts() + 1);
            for (const SurfacePiece& part : parts) {
                heap.push_back(part);
                std::ranges::push_heap(heap, is_lower);
            }
        }
        outcome.left.reserve(heap.size());
        for (const SurfacePiece& piece : heap) {
            if (piece.upper() > most()) {
                outcome.left.push_back(piece);
            } else {
                outcome.settled.add(piece.upper(), piece.cuts());
            }
        }
    }

    /// Some of the largest bounds among all that is pending, and drops what is settled by now.
    void take_pending(std::size_t most, std::vector<SurfacePiece>& pieces)
    {
        std::erase_if(pending_, [&](const SurfacePiece& piece) {
            if (piece.upper() > limit()) return false;
            settled_.add(piece.upper(), piece.cuts());
            return true;
        });
        const std::size_t count = std::min(most, pending_.size());
        const auto first = pending_.end() - static_cast<std::ptrdiff_t>(count);
        if (first != pending_.end()) std::ranges::nth_element(pending_, first, is_lower);
        pieces.assign(first, pending_.end());
        pending_.erase(first, pending_.end());
    }

    const SurfacePair& pair_;
    const MeasuredVertices& vertices_;
    const GreatestDeviationOptions& options_;
    double tolerance_;
    FarthestPoint farthest_;
    SettledBound settled_;
    std::vector<double> uppers_; ///< by row; 0 for triangles of B
    std::vector<std::uint32_t> order_;
    std::size_t done_ = 0; ///< of order_
    std::vector<SurfacePiece> pending_;
    std::uint64_t splits_ = 0;
    std::uint64_t local_splits_ = most_local_splits; ///< of one piece at a time
};

} // namespace

Result<GreatestDeviation> greatest_deviation(const MeshIndex& a, const MeshIndex& b,
                                             const GreatestDeviationOptions& options)
{
    if (!(options.tolerance >= 0)) {
        return fail(ErrorCode::invalid_argument, "the tolerance is no number from 0 up",
                    "tolerance");
    }
    const auto pair = SurfacePair::make(a, b, options.execution);
    if (!pair) return tl::unexpected(pair.error());
    const double tolerance = options.tolerance > 0
                                 ? pair->to_units(options.tolerance)
                                 : GreatestDeviationOptions::default_tolerance * pair->diagonal();
    const auto vertices = measure_vertices(*pair, options.execution);
    if (!vertices) return tl::unexpected(vertices.error());
    GreatestSearch search(*pair, *vertices, options, tolerance);
    if (Status status = search.run(); !status) return tl::unexpected(status.error());
    GreatestDeviation result = search.answer();
    result.is_complete = pair->to_units(result.distance.upper - result.distance.lower) <= tolerance;
    return result;
}

} // namespace proxima
