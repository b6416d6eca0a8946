// A triangle of A or a part of one, with bounds of the largest distance of its points from B.
//
//     lower   the distance of a corner
//     upper   of a row of B the distance of the farthest corner, for the distance from one triangle
//             is convex; the least over a few rows that are near
//
// Where one row is closest to all corners both are the same. Else the piece is cut: an edge whose ends
// have different rows where both are as near, an inside that three rows share where all three are.
// Pieces of a smooth surface need no more cuts than the closest row changes in them.
#pragma once

#include "query/deviation/surface_pair.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

class SurfacePiece {
public:
    static constexpr std::size_t most_rows = 6;
    static constexpr std::uint32_t most_cuts = 250;

    /// A triangle of A. `nearest` is that of its corners.
    SurfacePiece(const SurfacePair& pair, std::uint32_t row_a,
                 const std::array<NearestRow, 3>& nearest) noexcept;

    [[nodiscard]] double upper() const noexcept { return upper_; }
    [[nodiscard]] std::uint32_t row_a() const noexcept { return row_a_; }
    [[nodiscard]] std::uint32_t cuts() const noexcept { return cuts_; }
    [[nodiscard]] Vec3 centroid() const noexcept
    {
        return (corners_[0] + corners_[1] + corners_[2]) / 3;
    }
    /// More than the distance from B of a point of the piece, where it is that far from a corner.
    [[nodiscard]] double reach_of(const Vec3& p) const noexcept;

    /// Heeds another row. Where there are too many the one that says least is left out.
    void add_row(const SurfacePair& pair, std::uint32_t row) noexcept;

    /// Whether it is a whole triangle that is one of B's, bit for bit: then all distances are 0.
    [[nodiscard]] bool is_of_b(const SurfacePair& pair) const noexcept;

    /// A new corner, and what is closest to it.
    struct Cut {
        Vec3 point = Vec3::Zero();
        NearestRow nearest;
    };
    /// Appends two or three pieces that make up this one. Rows that are as near as another but for
    /// `slack` count as it. \pre cuts() < most_cuts
    Cut split(const SurfacePair& pair, double slack, std::vector<SurfacePiece>& to) const;

private:
    using Distances = std::array<double, 3>; ///< of the corners

    SurfacePiece() = default;
    void bound() noexcept;
    [[nodiscard]] std::size_t longest_side() const noexcept;
    struct Side {
        std::size_t side = 0;   ///< from corner `side` to the next
        double conflict = 0;    ///< by how much every row is farther than the closest at an end
        std::size_t common = 0; ///< the row for which that is least
    };
    [[nodiscard]] Side side_of(std::size_t side) const noexcept;
    [[nodiscard]] double point_between(const SurfacePair& pair, std::size_t side,
                                       double slack) const noexcept;
    [[nodiscard]] bool point_among(const SurfacePair& pair,
                                   const std::array<std::uint32_t, 3>& rows,
                                   Vec3& point) const noexcept;
    [[nodiscard]] bool is_well_inside(const Vec3& point) const noexcept;
    /// The piece with `cut` in the place of some corner. `at_cut` are the distances of the rows, and
    /// `row_distances` those of the cut's own row.
    [[nodiscard]] SurfacePiece with_corner(std::size_t corner, const Cut& cut,
                                           const std::array<double, most_rows>& at_cut,
                                           const Distances& of_new_row,
                                           double new_at_cut) const noexcept;

    std::array<Vec3, 3> corners_;
    Distances nearest_{};               ///< the distance of each from B
    std::array<std::uint8_t, 3> own_{}; ///< the closest row of each, in rows_
    std::uint8_t count_ = 0;
    std::uint32_t cuts_ = 0;
    std::uint32_t row_a_ = 0;
    std::array<std::uint32_t, most_rows> rows_{};
    std::array<Distances, most_rows> distances_{};
    double upper_ = 0;
};

} // namespace proxima
