// Bounds of the distance of a triangle of A from B where B lies along it: the triangle is cut into pieces,
// each with a row of B of its own. The distance from one row is convex, so it is largest at a piece's corners.
//
//     piece      a convex polygon; those of a triangle cover it
//     its row    where the piece is cut at an edge of the row, what is beyond gets the row across the edge
//
// The cut is in the plane that halves the angle of the two rows, where both are as far. No tree is searched, and no
// piece is cut whose bound is small enough with its row. Bounds are true whatever rows the pieces have: where no row
// across the edges is close, they are of no use.
#pragma once

#include "query/deviation/measured_part.h"
#include "query/deviation/row_triangle.h"
#include "query/deviation/surface_pair.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace proxima {

/// The rows of B on both sides of each edge.
class PROXIMA_HIDDEN RowNeighbors {
public:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    /// Of no rows.
    RowNeighbors() = default;
    explicit RowNeighbors(const IndexParts& b);
    [[nodiscard]] static std::uint64_t bytes_of(const IndexParts& b) noexcept;

    /// Another row with this edge, or none. Where an edge has more than two rows, one of the first two.
    [[nodiscard]] std::uint32_t across(std::uint32_t edge, std::uint32_t row) const noexcept
    {
        if (edge >= rows_.size()) return none;
        return rows_[edge][0] == row ? rows_[edge][1] : rows_[edge][0];
    }

private:
    std::vector<std::array<std::uint32_t, 2>> rows_; ///< by edge
};

/// A bound from above, the corner of a piece where it is reached, and how often pieces were cut.
struct CoverBound {
    double upper = 0;
    Vec3 point = Vec3::Zero();
    std::uint32_t cuts = 0; ///< at most, the ones before among them
};

/// Bounds one triangle of A after the other.
class PROXIMA_HIDDEN RowCover {
public:
    RowCover(const SurfacePair& pair, const RowNeighbors& neighbors) noexcept
        : pair_(pair), neighbors_(neighbors)
    {}

    /// About what a search takes at most.
    static constexpr std::uint64_t most_bytes = std::uint64_t{3} << 20U;

    /// A bound of the distances of a part's points. Pieces whose bound is at most `enough` are cut no further. Infinite where
    /// it would be no less than `known`, or there would be thousands of pieces or many cuts of one.
    [[nodiscard]] CoverBound bound(const MeasuredPart& part, double enough,
                                   double known = std::numeric_limits<double>::infinity());

private:
    static constexpr std::size_t most_corners = 10;
    static constexpr std::size_t most_kept = 1 << 14; ///< corners of all pieces
    static constexpr std::uint32_t most_deep = 64;    ///< cuts of a piece

    struct Piece {
        std::uint32_t first = 0; ///< of its corners
        std::uint32_t count = 0;
        std::uint32_t row = 0;
        std::uint32_t entered = RowNeighbors::none; ///< the edge that it is beyond of
        std::uint32_t cuts = 0;
        double upper = 0; ///< the distance of the farthest corner from the row
        std::uint32_t farthest = 0;
    };
    /// How far the corners of a piece are on this side of a plane.
    using Heights = std::array<double, most_corners>;

    void find_upper(Piece& piece, const RowTriangle& row) const noexcept;
    [[nodiscard]] bool cut(Piece& piece, const RowTriangle& row, std::size_t side);
    [[nodiscard]] Piece side_of(const Piece& piece, const Heights& heights, bool is_beyond);

    const SurfacePair& pair_;
    const RowNeighbors& neighbors_;
    Vec3 origin_ = Vec3::Zero();
    std::vector<Vec3> corners_; ///< of all pieces, from the origin
    std::vector<Piece> pending_;
};

} // namespace proxima
