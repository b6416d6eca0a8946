#include "query/deviation/mean_search.h"

#include <algorithm>
#include <utility>

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

/// Takes bounds from below where they are higher.
void raise_lower(MeanBounds& mean, const MeanBounds& lower) noexcept
{
    mean.lower = std::clamp(lower.lower, mean.lower, mean.upper);
    mean.squares_lower = std::clamp(lower.squares_lower, mean.squares_lower, mean.squares_upper);
}

} // namespace

MeanBounds lower_means(const std::array<Vec3, 3>& corners, CornerValues distances,
                       double rounding) noexcept
{
    double sides = 0;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double side = (corners[next_corner(k)] - corners[k]).squaredNorm();
        sides += side;
        longest = std::max(longest, side);
    }
    MeanBounds mean;
    for (double& distance : distances) distance -= rounding;
    const auto [a, b, c] = distances;
    const double least = std::min({a, b, c});
    if (!(least > 0)) return mean;
    const double below = (1 + 0x1p-40) * sides / 12;
    const double root = std::sqrt(std::max((1 - 0x1p-50) * least * least - longest / 3, 0.0));
    mean.lower = std::max(corner_sum(distances) / 3 - below / (least + root), 0.0);
    const double squares = (a * a + b * b + c * c) / 3;
    mean.squares_lower = std::max((1 - 0x1p-48) * squares - below, 0.0);
    return mean;
}

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

MeanSearch::MeanSearch(const SurfacePair& pair, const MeasuredVertices& vertices,
                       const MeanSearchOptions& options, const Progress* progress)
    : pair_(pair), progress_(progress), vertices_(vertices),
      tolerance_(std::max(options.tolerance - 4 * pair.rounding(64), 4 * pair.rounding(64))),
      root_share_(1 / std::max(2 * options.root, tolerance_)), spare_each_(options.spare),
      splits_left_(options.most_splits), pieces_(pair, 0.25 * tolerance_, options.bytes / 2),
      // Lists that grow take three times their size.
      most_pieces_(std::max(options.bytes, least_bytes) / 4 / (3 * sizeof(BoundedPiece))),
      most_parts_(std::max(options.bytes, least_bytes) / 4 / (3 * sizeof(MeanPart)))
{}

void MeanSearch::add_triangle(std::uint32_t row, MeanSums& sums, std::vector<MeanPart>* left)
{
    const Triangle triangle = pair_.a().triangle(row);
    double side = 0;
    for (int i = 0; i < 3; ++i)
        side = std::max(side, (triangle[(i + 1) % 3] - triangle[i]).squaredNorm());
    sums.area.add(area_of(triangle));
    // The second is for products below the doubles: the root of a square that became 0.
    sums.area_error.add(0x1p-48 * side + 0x1p-535);
    add_part({.part = {.corners = triangle.vertices, .nearest = vertices_.of_row(pair_.a(), row)},
              .row = row},
             sums, left);
}

void MeanSearch::add_part(const MeanPart& start, MeanSums& sums, std::vector<MeanPart>* left)
{
    area_ = area_of(pair_.a().triangle(start.row));
    spare_ += area_ * start.part.weight * spare_each_;
    const std::uint64_t splits_left = splits_left_;
    parts_.assign(1, start);
    if (left != nullptr) add_largest_first(sums, *left);
    while (!parts_.empty() && !is_cancelled(progress_)) {
        const MeanPart part = parts_.back();
        parts_.pop_back();
        look_at(part, sums);
    }
    sums.splits += splits_left - splits_left_;
}

/// Looks at parts in the order in which they were made, up to parts_alone of them, and moves as many of
/// the next ones as `left` takes.
void MeanSearch::add_largest_first(MeanSums& sums, std::vector<MeanPart>& left)
{
    for (std::size_t first = 0; first < parts_.size(); ++first) {
        if (is_cancelled(progress_)) return;
        if (first == parts_alone) {
            const auto from = parts_.begin() + parts_alone;
            const auto to = from + std::min(parts_.end() - from, std::ptrdiff_t{most_left});
            left.insert(left.end(), from, to);
            parts_.erase(parts_.begin(), to);
            return;
        }
        const MeanPart part = parts_[first];
        look_at(part, sums);
    }
    parts_.clear();
}

void MeanSearch::look_at(const MeanPart& pending, MeanSums& sums)
{
    const MeasuredPart& part = pending.part;
    const auto [rough, above] = rough_bounds(part);
    const double doubt = doubt_of(rough);
    const double allowed = allowance(part.weight);
    if (doubt <= allowed || !may_cut()) {
        settle(rough, above, part.weight, part.cuts, sums);
        spare_ += area_ * part.weight * (tolerance_ - doubt);
        return;
    }
    // Too many rows were near a part that held this one, and a few cuts will settle it without them.
    const bool waits = pending.waits > 0 && doubt <= 4 * allowed;
    NearPiece piece;
    if (!waits && pieces_.start(part, piece)) {
        refine(pending, piece, sums);
        return;
    }
    const std::uint32_t left = waits ? pending.waits - 1 : 2;
    for (const MeasuredPart& half : part.halves(pair_).parts)
        parts_.push_back({half, pending.row, left});
    --splits_left_;
}

/// Bounds without knowing all rows that are near: by those closest to the corners, and in
/// parts of triangles to the centroid where these leave too much in doubt.
MeanSearch::RoughBounds MeanSearch::rough_bounds(const MeasuredPart& part) const noexcept
{
    RoughBounds rough;
    double least = HUGE_VAL;
    const auto use_row = [&](std::uint32_t row) {
        CornerValues distances{};
        for (std::size_t k = 0; k < 3; ++k) distances[k] = pair_.distance(part.corners[k], row);
        if (!(corner_sum(distances) < least)) return;
        least = corner_sum(distances);
        rough.above = distances;
    };
    for (const NearestRow& nearest : part.nearest) use_row(nearest.row);
    rough.mean = mean_bounds(rough.above, {});
    const double rounding = pair_.rounding(part.cuts);
    const auto& [p, q, r] = part.corners;
    const CornerValues distances = {part.nearest[0].distance, part.nearest[1].distance,
                                    part.nearest[2].distance};
    raise_lower(rough.mean, lower_means({p, q, r}, distances, rounding));
    // Whole triangles have few rows near more often than not, and these say more.
    if (part.cuts == 0 || doubt_of(rough.mean) <= allowance(part.weight)) return rough;

    const Vec3 centroid = (p + q + r) / 3;
    const NearestRow nearest = pair_.nearest(centroid, part.reach(centroid));
    use_row(nearest.row);
    const MeanBounds whole = std::exchange(rough.mean, mean_bounds(rough.above, {}));
    raise_lower(rough.mean, whole);
    MeanBounds thirds;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = next_corner(k);
        const MeanBounds third =
            lower_means({part.corners[k], part.corners[next], centroid},
                        {distances[k], distances[next], nearest.distance}, rounding);
        thirds.lower += third.lower / 3;
        thirds.squares_lower += third.squares_lower / 3;
    }
    raise_lower(rough.mean, thirds);
    return rough;
}

void MeanSearch::refine(const MeanPart& start, const NearPiece& whole, MeanSums& sums)
{
    const double weight = start.part.weight;
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
            start_anew(start, doubt, sums);
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
void MeanSearch::start_anew(const MeanPart& start, double doubt, MeanSums& sums)
{
    const double weight = start.part.weight;
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
        parts_.push_back({part, start.row, 0});
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
