#include "query/deviation/mean_search.h"

#include <algorithm>

namespace proxima {

namespace {

/// The mean of the square of a linear function over a triangle, by its values at the corners.
double mean_of_squares(const CornerValues& values) noexcept
{
    const double sum = corner_sum(values);
    const double squares = values[0] * values[0] + values[1] * values[1] + values[2] * values[2];
    return (squares + sum * sum) / 12;
}

/// The means of a linear function, and of its square, where negative values count as 0.
void set_lower(MeanBounds& mean, CornerValues values) noexcept
{
    std::ranges::sort(values);
    const auto [a, b, c] = values;
    if (!(c > 0)) return;
    if (a >= 0) {
        mean.lower = corner_sum(values) / 3;
        mean.squares_lower = mean_of_squares(values);
    } else if (b <= 0) { // positive in a corner
        const double share = c / (c - a) * (c / (c - b));
        mean.lower = share * c / 3;
        mean.squares_lower = share * c * c / 6;
    } else { // negative in a corner
        const double share = a / (a - b) * (a / (a - c));
        mean.lower = (corner_sum(values) - share * a) / 3;
        mean.squares_lower =
            mean_of_squares(values) - share * a * a / 6 - 0x1p-48 * (a * a + c * c);
    }
}

} // namespace

MeanBounds mean_bounds(const CornerValues& above, const CornerValues& below) noexcept
{
    MeanBounds mean;
    mean.upper = corner_sum(above) / 3;
    mean.squares_upper = mean_of_squares(above);
    set_lower(mean, below);
    mean.lower = std::clamp(mean.lower, 0.0, mean.upper);
    mean.squares_lower = std::clamp(mean.squares_lower, 0.0, mean.squares_upper);
    return mean;
}

void MeanSums::add(const MeanSums& some)
{
    area.add(some.area.value());
    area_error.add(some.area_error.value());
    lower.add(some.lower.value());
    upper.add(some.upper.value());
    squares_lower.add(some.squares_lower.value());
    squares_upper.add(some.squares_upper.value());
    farthest = std::max(farthest, some.farthest);
    splits += some.splits;
    cuts = std::max(cuts, some.cuts);
    histogram.add(some.histogram);
}

MeanSearch::MeanSearch(const SurfacePair& pair, const MeasuredVertices& vertices, double tolerance,
                       double root, std::uint64_t most_splits, std::uint64_t bytes,
                       const Progress* progress)
    : pair_(pair), progress_(progress), vertices_(vertices),
      tolerance_(std::max(tolerance - 4 * pair.rounding(64), 4 * pair.rounding(64))),
      root_share_(1 / std::max(2 * root, tolerance_)), splits_left_(most_splits),
      pieces_(pair, 0.25 * tolerance_, bytes / 2),
      // Lists that grow take three times their size.
      most_pieces_(std::max(bytes, least_bytes) / 4 / (3 * sizeof(BoundedPiece))),
      most_parts_(std::max(bytes, least_bytes) / 4 / (3 * sizeof(MeasuredPart)))
{}

void MeanSearch::add_triangle(std::uint32_t row, MeanSums& sums)
{
    const Triangle triangle = pair_.a().triangle(row);
    area_ = 0.5 * scaled_normal(triangle).norm();
    double side = 0;
    for (int i = 0; i < 3; ++i)
        side = std::max(side, (triangle[(i + 1) % 3] - triangle[i]).squaredNorm());
    sums.area.add(area_);
    sums.area_error.add(0x1p-48 * side);
    const std::uint64_t splits_left = splits_left_;
    parts_.clear();
    parts_.push_back({.corners = triangle.vertices, .nearest = vertices_.of_row(pair_.a(), row)});
    while (!parts_.empty()) {
        const MeasuredPart part = parts_.back();
        parts_.pop_back();
        add_part(part, sums);
        if (is_cancelled(progress_)) return;
    }
    sums.splits += splits_left - splits_left_;
}

void MeanSearch::add_part(const MeasuredPart& part, MeanSums& sums)
{
    CornerValues above{};
    const MeanBounds rough = rough_bounds(part, above);
    const double doubt = doubt_of(rough);
    NearPiece piece;
    if (doubt <= allowance(part.weight) || !may_cut()) {
        settle(rough, above, part.weight, part.cuts, sums);
        spare_ += area_ * part.weight * (tolerance_ - doubt);
    } else if (pieces_.start(part, piece)) {
        refine(piece, part.weight, sums);
    } else {
        for (const MeasuredPart& half : part.halves(pair_).parts) parts_.push_back(half);
        --splits_left_;
    }
}

/// Bounds without knowing the rows: by those closest to the corners.
MeanBounds MeanSearch::rough_bounds(const MeasuredPart& part, CornerValues& above) const noexcept
{
    double least = HUGE_VAL;
    for (const NearestRow& nearest : part.nearest) {
        CornerValues distances{};
        for (std::size_t k = 0; k < 3; ++k)
            distances[k] = pair_.distance(part.corners[k], nearest.row);
        if (!(corner_sum(distances) < least)) continue;
        least = corner_sum(distances);
        above = distances;
    }
    // The squared distance from any set less that from a fixed point is concave, so the square is above
    // what joins its corners less the variance of the corners, a third of a squared side at most.
    const std::size_t side = longest_side_of(part.corners);
    const double variance =
        (part.corners[next_corner(side)] - part.corners[side]).squaredNorm() / 3;
    CornerValues below{};
    for (std::size_t i = 0; i < 3; ++i) {
        // The distance may be too large by its rounding, of which the root near 0 makes more.
        const double distance = part.nearest[i].distance;
        const double squared =
            distance * distance - variance - 2 * distance * pair_.rounding(part.cuts);
        if (squared < 0) return mean_bounds(above, {});
        below[i] = std::sqrt(squared);
    }
    return mean_bounds(above, below);
}

void MeanSearch::refine(const NearPiece& whole, double weight, MeanSums& sums)
{
    heap_.clear();
    double doubt = 0;
    const auto has_less_doubt = [](const BoundedPiece& one, const BoundedPiece& other) {
        return one.doubt < other.doubt;
    };
    const auto take = [&](const NearPiece& piece) {
        const MeanBounds mean = mean_bounds(piece.above, piece.below);
        const double own = doubt_of(mean);
        doubt += piece.weight * own;
        if (own <= 0.1 * tolerance_) {
            settle(mean, piece.above, weight * piece.weight, piece.cuts, sums);
            return;
        }
        heap_.push_back({piece, mean, piece.weight * own});
        std::ranges::push_heap(heap_, has_less_doubt);
    };
    take(whole);
    const double allowed = allowance(weight);
    for (std::uint64_t count = 1; !heap_.empty() && doubt > allowed; ++count) {
        if (count % 64 == 0 && is_cancelled(progress_)) return;
        if (!may_cut()) break;
        if (pieces_.is_full() || heap_.size() > most_pieces_) {
            start_anew(weight, doubt, sums);
            return;
        }
        std::ranges::pop_heap(heap_, has_less_doubt);
        const BoundedPiece most = heap_.back();
        heap_.pop_back();
        doubt -= most.doubt;
        for (const NearPiece& piece : pieces_.split(most.piece).parts) take(piece);
        --splits_left_;
    }
    for (const auto& [piece, mean, own] : heap_)
        settle(mean, piece.above, weight * piece.weight, piece.cuts, sums);
    spare_ += area_ * weight * (tolerance_ - doubt);
}

/// Makes parts of the pieces that are too much in doubt, which collect their rows anew.
void MeanSearch::start_anew(double weight, double doubt, MeanSums& sums)
{
    double left = 0;
    for (const auto& [piece, mean, own] : heap_) {
        if (own <= tolerance_ * piece.weight) {
            settle(mean, piece.above, weight * piece.weight, piece.cuts, sums);
            continue;
        }
        doubt -= own;
        left += piece.weight;
        MeasuredPart part = pieces_.part(piece);
        part.weight *= weight;
        parts_.push_back(part);
    }
    spare_ += area_ * weight * (tolerance_ * (1 - left) - doubt);
}

/// How far the bounds of the mean are apart, or those of the root of squares if that is more.
double MeanSearch::doubt_of(const MeanBounds& mean) const noexcept
{
    return std::max(mean.upper - mean.lower,
                    root_share_ * (mean.squares_upper - mean.squares_lower));
}

/// How much a part may be in doubt: the tolerance, and some of what others left of theirs.
double MeanSearch::allowance(double weight) const noexcept
{
    if (!(area_ > 0)) return HUGE_VAL;
    const double own = tolerance_ + spare_ / (area_ * weight);
    return std::clamp(own, 0.5 * tolerance_, 4 * tolerance_);
}

void MeanSearch::settle(const MeanBounds& mean, const CornerValues& above, double weight,
                        std::uint32_t cuts, MeanSums& sums) const
{
    const double area = area_ * weight;
    sums.lower.add(area * mean.lower);
    sums.upper.add(area * mean.upper);
    sums.squares_lower.add(area * mean.squares_lower);
    sums.squares_upper.add(area * mean.squares_upper);
    sums.farthest = std::max(sums.farthest, *std::ranges::max_element(above));
    sums.cuts = std::max(sums.cuts, cuts);
    sums.histogram.add(area, above);
}

} // namespace proxima
