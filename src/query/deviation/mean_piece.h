// A triangle of A or a part of one, with bounds of the mean distance of its points from B.
//
//     above   the distances of the corners from one row of B, joined linearly: the distance from one
//             triangle is convex
//     below   of each row that may be closest somewhere the tangent at the centroid, convex functions
//             being above theirs; the least of them is concave, so above what joins its corners
//
// Rows whose tangent is above the first everywhere are not closest anywhere in the piece, nor in its
// parts. Where one row is left whose plane holds the feet, both bounds are the same.
//
// A piece that too many rows are near to has none. The squared distance from any set less that from a
// fixed point is concave, so d^2 >= sum of w_i d_i^2 - V at the point with weights w_i of corners at
// distances d_i, where V <= side^2 / 3 is the variance of the corners with these weights.
#pragma once

#include "query/deviation/surface_pair.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

struct MeanPiece {
    std::array<Vec3, 3> corners;
    std::array<NearestRow, 3> nearest{}; ///< of the corners, where there are no rows
    std::array<double, 3> above{};       ///< at the corners
    double weight = 1;                   ///< its part of the triangle's area
    double mean_lower = 0;
    double mean_upper = 0;
    double squares_lower = 0; ///< of the mean of squared distances
    double squares_upper = 0;
    std::size_t first_row = 0; ///< in the arena of rows
    std::uint32_t row_count = 0;
    std::uint32_t cuts = 0;
    std::uint8_t side = 0; ///< to be cut next, at `part` of the way
    double part = 0.5;

    [[nodiscard]] bool has_rows() const noexcept { return row_count != 0; }
    /// How much of the uncertainty of the triangle's mean it is.
    [[nodiscard]] double doubt() const noexcept { return weight * (mean_upper - mean_lower); }
};

/// Bounds pieces of one triangle of A after the other.
class PROXIMA_HIDDEN MeanPieces {
public:
    /// `doubt` is how far bounds of a mean may be apart where more would be of no use.
    MeanPieces(const SurfacePair& pair, double doubt) noexcept : pair_(pair), doubt_(doubt) {}

    /// A triangle of A, whose corners have these nearest rows. Forgets pieces made before.
    [[nodiscard]] MeanPiece whole(std::uint32_t row_a, const std::array<NearestRow, 3>& nearest);

    /// The two parts of a piece.
    [[nodiscard]] std::array<MeanPiece, 2> split(const MeanPiece& piece);

    /// Whether so many rows are kept for pieces of one triangle that no more should be cut.
    [[nodiscard]] bool is_full() const noexcept { return rows_.size() > (std::size_t{1} << 25U); }

private:
    static constexpr std::size_t most_rows = 128;

    struct Tangent {
        std::uint32_t row = 0;
        double distance = 0;             ///< of the centroid
        std::array<double, 3> corners{}; ///< where it is at the corners
    };

    void bound(MeanPiece& piece);
    void bound_without_rows(MeanPiece& piece) const;
    [[nodiscard]] bool collect_rows(MeanPiece& piece);
    void bound_by_rows(MeanPiece& piece);
    void choose_cut(MeanPiece& piece, const std::array<double, 3>& below,
                    const std::array<std::size_t, 3>& lowest) const;
    [[nodiscard]] std::array<double, 3> distances(const MeanPiece& piece,
                                                  std::uint32_t row) const noexcept;

    const SurfacePair& pair_;
    double doubt_;
    std::vector<std::uint32_t> rows_; ///< of all pieces
    std::vector<Tangent> tangents_;
};

} // namespace proxima
