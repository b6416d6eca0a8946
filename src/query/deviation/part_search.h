// The greatest distance of parts of A from B, a few cuts at a time.
#pragma once

#include "query/deviation/measured_part.h"
#include "query/deviation/near_pieces.h"
#include "query/deviation/row_cover.h"
#include "query/deviation/surface_pair.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

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
    /// For bounds that rest on corners that were cut so often.
    void allow(std::uint32_t cut_count) noexcept { cuts = std::max(cuts, cut_count); }
    void add(const SettledBound& other)
    {
        upper = std::max(upper, other.upper);
        cuts = std::max(cuts, other.cuts);
        is_zero = is_zero && other.is_zero;
    }
};

/// What a few cuts of one part gave.
struct PartOutcome {
    FarthestPoint farthest;
    SettledBound settled;
    std::vector<BoundedPart> left;
    std::uint64_t splits = 0;
};

/// Bounds one triangle of A or part of one after the other.
class PROXIMA_HIDDEN PartSearch {
public:
    static constexpr std::uint32_t most_cuts = 250;

    /// `greatest` is the largest distance known, `most_splits` those of each part. Takes about
    /// `bytes`.
    PartSearch(const SurfacePair& pair, const RowNeighbors& neighbors, double tolerance,
               double greatest, std::uint64_t most_splits, std::uint64_t bytes) noexcept
        : pair_(pair), tolerance_(tolerance), greatest_(greatest), most_splits_(most_splits),
          cover_(pair, neighbors), pieces_(pair, tolerance, bytes)
    {}

    /// Lowers the bound where B lies along the part, and asks how far the point is where it is reached. Parts whose bound is
    /// no more than the tolerance above the greatest distance are of no more interest.
    void cover(BoundedPart& part, PartOutcome& outcome);

    /// `upper` bounds the distances of the triangle's points.
    void search_triangle(const MeasuredVertices& vertices, std::uint32_t row, double upper,
                         PartOutcome& outcome);
    /// A few cuts, always of the piece with the largest bound.
    void search_part(BoundedPart start, PartOutcome& outcome);

private:
    void offer_corner(const MeasuredPart& part, std::size_t corner, std::uint32_t row_a,
                      PartOutcome& outcome) const;
    void halve(const BoundedPart& start, PartOutcome& outcome) const;
    [[nodiscard]] double greatest(const PartOutcome& outcome) const noexcept
    {
        return std::max(greatest_, outcome.farthest.nearest.distance);
    }
    [[nodiscard]] double limit(const PartOutcome& outcome) const noexcept
    {
        return greatest(outcome) + tolerance_;
    }

    const SurfacePair& pair_;
    double tolerance_;
    double greatest_;
    std::uint64_t most_splits_;
    RowCover cover_;
    NearPieces pieces_;
};

} // namespace proxima
