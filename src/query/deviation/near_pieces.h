// Parts of one triangle of A, cut along the lines where the closest triangle of B changes, with bounds of
// the distance of their points from B.
//
//     above   the distances of the corners from one row of B, joined linearly: the distance from one
//             triangle is convex
//     below   of each row that may be closest somewhere a slab that holds it (row_triangle.h), whose
//             distance is linear; the least of them is concave, so above what joins its corners
//
// Rows that are nowhere closer than the first are left out, in the piece and in its parts. Where one row
// is left whose plane holds the feet, both bounds are the same.
#pragma once

#include "query/deviation/measured_part.h"
#include "query/deviation/row_triangle.h"
#include "query/deviation/surface_pair.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// A part of a part whose rows are known.
struct NearPiece {
    std::array<Vec3, 3> corners; ///< from the origin
    CornerValues above{};
    CornerValues below{};
    double weight = 1; ///< its part of the part's area
    double lost = 0;   ///< how far rows that were left out may be below those that were not
    std::uint32_t first_row = 0;
    std::uint32_t row_count = 0;
    std::uint32_t cuts = 0;
};

/// Both parts of a piece, and which corner of the first one is new.
struct SplitPiece {
    std::array<NearPiece, 2> parts;
    std::size_t corner = 0;
};

/// Bounds the pieces of one part after the other.
class PROXIMA_HIDDEN NearPieces {
public:
    /// `doubt` is how far bounds may be apart where more would be of no use. Takes about `bytes`, or
    /// half a megabyte if that is more.
    NearPieces(const SurfacePair& pair, double doubt, std::uint64_t bytes) noexcept
        : pair_(pair), doubt_(doubt),
          most_feet_(std::clamp<std::uint64_t>(bytes / foot_bytes, 1 << 10, 1 << 17))
    {}
    /// More is of no use.
    static constexpr std::uint64_t most_bytes = std::uint64_t{32} << 20U;

    /// Takes all rows of B that may be closest to a point of the part, and makes a piece of it. False
    /// where they are too many. Forgets the pieces made before.
    [[nodiscard]] bool start(const MeasuredPart& part, NearPiece& piece);

    /// Cuts a piece where the closest row changes, where the surfaces cross, or in the middle.
    [[nodiscard]] SplitPiece split(const NearPiece& piece);

    /// Whether so much is kept that what is left should be started anew.
    [[nodiscard]] bool is_full() const noexcept { return feet_.size() > most_feet_; }

    /// The least over the rows of the distance of the farthest corner.
    [[nodiscard]] double upper(const NearPiece& piece) const noexcept;

    /// A piece as a part that starts anew.
    [[nodiscard]] MeasuredPart part(const NearPiece& piece) const noexcept;

private:
    static constexpr std::size_t most_rows = 256;

    /// A row in a piece, and what the piece's corners say of it.
    struct PieceRow {
        std::uint32_t near = 0;
        std::array<std::uint32_t, 3> feet{};
    };
    // A cut makes a foot of each row, and the row in two pieces; lists that grow take three times theirs.
    static constexpr std::uint64_t foot_bytes = 3 * (sizeof(TriangleFoot) + 2 * sizeof(PieceRow));
    struct RowBounds;

    [[nodiscard]] bool collect(const MeasuredPart& part);
    void drop_far(double within) noexcept;
    void bound(NearPiece& piece, std::size_t first, std::size_t count);
    [[nodiscard]] RowBounds bounds_of(const NearPiece& piece, const PieceRow& row,
                                      double slack) const noexcept;
    [[nodiscard]] double distance(const PieceRow& row, std::size_t corner) const noexcept
    {
        return feet_[row.feet[corner]].distance;
    }
    /// From a corner to the next, at `share` of the way.
    struct Cut {
        std::size_t side = 0;
        double share = 0.5;
    };
    [[nodiscard]] Cut choose_cut(const NearPiece& piece) const noexcept;
    struct Side {
        std::size_t side = 3;
        double conflict = 0; ///< by how much every row is farther than the closest at an end
    };
    [[nodiscard]] Side worst_side(const NearPiece& piece) const noexcept;
    [[nodiscard]] const PieceRow& closest_at(const NearPiece& piece, std::size_t corner,
                                             std::size_t other) const noexcept;
    [[nodiscard]] double change(const NearPiece& piece, std::size_t from) const noexcept;
    [[nodiscard]] double leaving(const NearPiece& piece, const PieceRow& row, std::size_t from,
                                 std::size_t to) const noexcept;
    [[nodiscard]] Vec3 across(const NearPiece& piece, const RowTriangle& triangle,
                              std::size_t side) const noexcept;

    const SurfacePair& pair_;
    double doubt_;
    std::size_t most_feet_;
    Vec3 origin_ = Vec3::Zero();
    std::vector<RowTriangle> near_;
    std::vector<double> center_distances_;
    std::vector<TriangleFoot> feet_;
    std::vector<PieceRow> rows_; ///< of all pieces
};

} // namespace proxima
