// Sums of the bounds of the mean deviation over triangles of A, whose parts are cut as far as is needed.
#pragma once

#include "base/progress.h"
#include "query/deviation/area_histogram.h"
#include "query/deviation/near_pieces.h"
#include "query/deviation/surface_pair.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace proxima {

/// A sum of many numbers that is off by two roundings of itself [neumaier-1974].
class LongSum {
public:
    void add(double value) noexcept
    {
        const double sum = sum_ + value;
        rest_ += std::abs(sum_) >= std::abs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
        sum_ = sum;
    }
    [[nodiscard]] double value() const noexcept { return sum_ + rest_; }

private:
    double sum_ = 0;
    double rest_ = 0;
};

/// What some triangles of A add up to.
struct MeanSums {
    explicit MeanSums(const AreaHistogram& empty) : histogram(empty) {}
    void add(const MeanSums& some);

    LongSum area;
    LongSum area_error; ///< by which areas may be off
    LongSum lower;
    LongSum upper;
    LongSum squares_lower;
    LongSum squares_upper;
    double farthest = 0;
    std::uint64_t splits = 0;
    std::uint32_t cuts = 0;
    AreaHistogram histogram;
};

/// Bounds of the mean of distances over a piece, and of their squares.
struct MeanBounds {
    double lower = 0;
    double upper = 0;
    double squares_lower = 0;
    double squares_upper = 0;
};

/// From linear bounds, by their values at the corners. Where `below` is negative, 0 is the bound.
[[nodiscard]] MeanBounds mean_bounds(const CornerValues& above, const CornerValues& below) noexcept;

/// Adds triangles of A one after the other. What one leaves of the tolerance the next ones may use.
class PROXIMA_HIDDEN MeanSearch {
public:
    /// `root` is about the root mean square, `most_splits` for all triangles together. Takes about
    /// `bytes`, or least_bytes if that is more.
    MeanSearch(const SurfacePair& pair, const MeasuredVertices& vertices, double tolerance,
               double root, std::uint64_t most_splits, std::uint64_t bytes,
               const Progress* progress);
    static constexpr std::uint64_t least_bytes = std::uint64_t{1} << 20U;
    static constexpr std::uint64_t most_bytes = 2 * NearPieces::most_bytes; ///< more is of no use

    /// Ends soon where the progress asks for it; then the sums are of no use.
    void add_triangle(std::uint32_t row, MeanSums& sums);

private:
    struct BoundedPiece {
        NearPiece piece;
        MeanBounds mean;
        double doubt = 0; ///< by its weight
    };

    [[nodiscard]] bool may_cut() const noexcept
    {
        return splits_left_ > 0 && parts_.size() < most_parts_;
    }
    void add_part(const MeasuredPart& part, MeanSums& sums);
    void refine(const NearPiece& whole, double weight, MeanSums& sums);
    void start_anew(double weight, double doubt, MeanSums& sums);
    [[nodiscard]] MeanBounds rough_bounds(const MeasuredPart& part,
                                          CornerValues& above) const noexcept;
    [[nodiscard]] double doubt_of(const MeanBounds& mean) const noexcept;
    [[nodiscard]] double allowance(double weight) const noexcept;
    void settle(const MeanBounds& mean, const CornerValues& above, double weight,
                std::uint32_t cuts, MeanSums& sums) const;

    const SurfacePair& pair_;
    const Progress* progress_;
    const MeasuredVertices& vertices_;
    double tolerance_;
    double root_share_; ///< of a doubt of squares in one of their root
    std::uint64_t splits_left_;
    NearPieces pieces_;
    std::size_t most_pieces_;
    std::size_t most_parts_;
    std::vector<BoundedPiece> heap_;
    std::vector<MeasuredPart> parts_; ///< of the triangle, not looked at yet
    double area_ = 0;
    double spare_ = 0; ///< what parts left of their tolerance, times area
};

} // namespace proxima
