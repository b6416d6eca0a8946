#include "query/deviation/row_cover.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// In the triangle's plane, across a side and to the inside, of length 1, or 0 where there is none.
Vec3 inward_of(const Triangle& triangle, std::size_t side) noexcept
{
    const auto& corners = triangle.vertices;
    const std::size_t next = next_corner(side);
    const Vec3 along = corners[next] - corners[side];
    const Vec3 to_apex = corners[next_corner(next)] - corners[side];
    const double squared = along.squaredNorm();
    if (!(squared > 0)) return Vec3::Zero();
    const Vec3 inward = to_apex - (to_apex.dot(along) / squared) * along;
    const double length = inward.norm();
    return length > 0 ? Vec3(inward / length) : Vec3::Zero();
}

} // namespace

RowNeighbors::RowNeighbors(const IndexParts& b) : rows_(b.edge_count(), {none, none})
{
    for (std::uint32_t row = 0; row < b.triangle_count(); ++row) {
        for (const std::uint32_t edge : edges_of(b, row)) {
            if (edge >= rows_.size()) continue;
            for (std::uint32_t& place : rows_[edge]) {
                if (place == row) break;
                if (place != none) continue;
                place = row;
                break;
            }
        }
    }
}

std::uint64_t RowNeighbors::bytes_of(const IndexParts& b) noexcept
{
    return b.edge_count() * sizeof(std::array<std::uint32_t, 2>);
}

CoverBound RowCover::bound(const MeasuredPart& part, double enough, double known)
{
    origin_ = part.corners[0];
    corners_.clear();
    for (const Vec3& corner : part.corners) corners_.emplace_back(corner - origin_);
    pending_.assign(1, {.count = 3, .row = part.nearest[0].row, .cuts = part.cuts});
    CoverBound result{.point = part.corners[0]};
    while (!pending_.empty()) {
        if (corners_.size() > most_kept) return {.upper = HUGE_VAL};
        Piece piece = pending_.back();
        pending_.pop_back();
        // Round a vertex, pieces may pass from row to row without end.
        if (piece.cuts > part.cuts + most_deep) return {.upper = HUGE_VAL};
        const RowTriangle row(pair_.b().triangle(piece.row), origin_, piece.row,
                              edges_of(pair_.b(), piece.row));
        find_upper(piece, row);
        if (piece.upper > enough) {
            bool is_cut = false;
            for (std::size_t side = 0; side < 3 && piece.count != 0; ++side) {
                if (row.edges()[side] != piece.entered) is_cut |= cut(piece, row, side);
            }
            if (is_cut) find_upper(piece, row);
        }
        result.cuts = std::max(result.cuts, piece.cuts + 1);
        if (!(piece.upper > result.upper)) continue;
        if (piece.upper >= known) return {.upper = HUGE_VAL};
        result.upper = piece.upper;
        result.point = origin_ + corners_[piece.farthest];
    }
    return result;
}

void RowCover::find_upper(Piece& piece, const RowTriangle& row) const noexcept
{
    piece.upper = 0;
    for (std::uint32_t i = piece.first; i < piece.first + piece.count; ++i) {
        const double distance = row.distance(corners_[i]);
        if (!(distance > piece.upper)) continue;
        piece.upper = distance;
        piece.farthest = i;
    }
}

/// Leaves the piece what is on this side of one of its row's edges, which may be nothing, and keeps the rest for later
/// with the row across. False where all is on this side.
bool RowCover::cut(Piece& piece, const RowTriangle& row, std::size_t side)
{
    const std::uint32_t edge = row.edges()[side];
    const std::uint32_t next = neighbors_.across(edge, row.row());
    if (next == RowNeighbors::none || piece.count + 2 > most_corners) return false;
    const auto edges = edges_of(pair_.b(), next);
    const auto next_side = static_cast<std::size_t>(std::ranges::find(edges, edge) - edges.begin());
    const Vec3 normal = inward_of(pair_.b().triangle(row.row()), side) -
                        inward_of(pair_.b().triangle(next), next_side);
    Heights heights{};
    std::size_t changes = 0;
    bool is_any_beyond = false;
    for (std::size_t i = 0; i < piece.count; ++i) {
        heights[i] = normal.dot(corners_[piece.first + i] - row.corner(side));
        is_any_beyond = is_any_beyond || heights[i] < 0;
        if (i > 0 && (heights[i] < 0) != (heights[i - 1] < 0)) ++changes;
    }
    // More changes are of rounding.
    if (!is_any_beyond || changes > 2) return false;
    Piece beyond = side_of(piece, heights, true);
    beyond.row = next;
    beyond.entered = edge;
    pending_.push_back(beyond);
    piece = side_of(piece, heights, false);
    return true;
}

/// What of a piece is on one side of a plane.
RowCover::Piece RowCover::side_of(const Piece& piece, const Heights& heights, bool is_beyond)
{
    Piece part = piece;
    part.first = static_cast<std::uint32_t>(corners_.size());
    ++part.cuts;
    for (std::size_t i = 0; i < piece.count; ++i) {
        const std::size_t k = i + 1 == piece.count ? 0 : i + 1;
        const Vec3 from = corners_[piece.first + i];
        const Vec3 to = corners_[piece.first + k];
        if ((heights[i] < 0) == is_beyond) corners_.push_back(from);
        if ((heights[i] < 0) != (heights[k] < 0))
            corners_.emplace_back(from + (heights[i] / (heights[i] - heights[k])) * (to - from));
    }
    part.count = static_cast<std::uint32_t>(corners_.size()) - part.first;
    return part;
}

} // namespace proxima
