// Sums of the bounds of the mean deviation over triangles of A, whose parts are cut as far as is needed.
#pragma once

#include "base/progress.h"
#include "query/deviation/area_histogram.h"
#include "query/deviation/near_pieces.h"
#include "query/deviation/surface_pair.h"

#include <cmath>
#include <cstdint>
#include <utility>
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
    explicit MeanSums(AreaHistogram empty) : histogram(std::move(empty)) {}
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

/// The means over a triangle from below (`lower` and `squares_lower`), by its corners' distances from
/// B, which may be too large by the rounding.
///
/// The squared distance from any set less that from a fixed point is concave. So it is at least l - v,
/// with l linear between the corners' squares and v, by how much what joins the corners' squared ways
/// from a fixed point is above that of x: a twelfth of the sum of the squared sides in the mean, a
/// third of the longest at most. With m the least corner's distance the distance is at least
///
///     l^(1/2) - v / (m + (m^2 - max v)^(1/2)),   where m^2 < max v  l^(1/2) - v / m,
///
/// and l^(1/2) is above what joins the corners' distances.
[[nodiscard]] MeanBounds lower_means(const std::array<Vec3, 3>& corners, CornerValues distances,
                                     double rounding) noexcept;

/// What half the length of a triangle's scaled normal is.
[[nodiscard]] inline double area_of(const Triangle& triangle) noexcept
{
    return 0.5 * scaled_normal(triangle).norm();
}

/// A triangle of A or a part of one that is not looked at yet.
struct MeanPart {
    MeasuredPart part;
    std::uint32_t row = 0;   ///< of A
    std::uint32_t waits = 0; ///< how many cuts may pass before rows are collected again
};

struct MeanSearchOptions {
    double tolerance = 0;
    double root = 0;  ///< about the root mean square
    double spare = 0; ///< of their tolerance that others left to each part, as a distance
    std::uint64_t most_splits = 0; ///< of all that is added
    std::uint64_t bytes = 0;       ///< takes about as many, or least_bytes if that is more
};

/// Adds triangles of A, or parts of them, one after the other. What one leaves of the tolerance the next
/// ones may use.
class PROXIMA_HIDDEN MeanSearch {
public:
    MeanSearch(const SurfacePair& pair, const MeasuredVertices& vertices,
               const MeanSearchOptions& options, const Progress* progress);
    static constexpr std::uint64_t least_bytes = std::uint64_t{1} << 20U;
    static constexpr std::uint64_t most_bytes = 2 * NearPieces::most_bytes; ///< more is of no use
    /// With `left`, what remains after so many parts of one triangle is added there, as far as
    /// most_left parts go.
    static constexpr std::size_t parts_alone = 64;
    static constexpr std::size_t most_left = parts_alone + 1;

    /// Ends soon where the progress asks for it; then the sums are of no use.
    void add_triangle(std::uint32_t row, MeanSums& sums, std::vector<MeanPart>* left);
    /// Like add_triangle, but the areas of the whole triangle are not added again.
    void add_part(const MeanPart& start, MeanSums& sums, std::vector<MeanPart>* left);

    /// What was left of the tolerance, times area.
    [[nodiscard]] double spare() const noexcept { return spare_; }

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
    void add_largest_first(MeanSums& sums, std::vector<MeanPart>& left);
    void look_at(const MeanPart& pending, MeanSums& sums);
    void refine(const MeanPart& start, const NearPiece& whole, MeanSums& sums);
    void start_anew(const MeanPart& start, double doubt, MeanSums& sums);
    struct RoughBounds {
        MeanBounds mean;
        CornerValues above{};
    };
    [[nodiscard]] RoughBounds rough_bounds(const MeasuredPart& part) const noexcept;
    [[nodiscard]] double doubt_of(const MeanBounds& mean) const noexcept;
    [[nodiscard]] double allowance(double weight) const noexcept;
    void settle(const MeanBounds& mean, const CornerValues& above, double weight,
                std::uint32_t cuts, MeanSums& sums) const;

    const SurfacePair& pair_;
    const Progress* progress_;
    const MeasuredVertices& vertices_;
    double tolerance_;
    double root_share_; ///< of a doubt of squares in one of their root
    double spare_each_;
    std::uint64_t splits_left_;
    NearPieces pieces_;
    std::size_t most_pieces_;
    std::size_t most_parts_;
    std::vector<BoundedPiece> heap_;
    std::vector<MeanPart> parts_; ///< of the triangle, not looked at yet
    double area_ = 0;
    double spare_ = 0; ///< what parts left of their tolerance, times area
};

} // namespace proxima
