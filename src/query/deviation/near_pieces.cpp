#include "query/deviation/near_pieces.h"

#include "index/visit_near.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

Vec3 centroid_of(const std::array<Vec3, 3>& corners) noexcept
{
    return (corners[0] + corners[1] + corners[2]) / 3;
}

double radius_about(const Vec3& center, const std::array<Vec3, 3>& corners) noexcept
{
    double most = 0;
    for (const Vec3& corner : corners) most = std::max(most, (corner - center).squaredNorm());
    return std::sqrt(most);
}

/// Where a linear function is 0 on a side, by its values at the ends; negative where it does not fall.
double falling_root(double from, double to) noexcept
{
    return from > 0 && to < 0 ? from / (from - to) : -1;
}

} // namespace

bool NearPieces::start(const MeasuredPart& part, NearPiece& piece)
{
    origin_ = part.corners[0];
    if (!collect(part)) return false;
    piece = NearPiece{};
    piece.cuts = part.cuts;
    for (std::size_t i = 0; i < 3; ++i) piece.corners[i] = part.corners[i] - origin_;
    feet_.clear();
    rows_.clear();
    for (std::uint32_t i = 0; i < near_.size(); ++i) {
        const auto first = static_cast<std::uint32_t>(feet_.size());
        rows_.push_back({.near = i, .feet = {first, first + 1, first + 2}});
        for (const Vec3& corner : piece.corners) feet_.push_back(near_[i].foot(corner));
    }
    bound(piece, 0, rows_.size());
    return true;
}

/// All rows that may be closest to a point of the part.
bool NearPieces::collect(const MeasuredPart& part)
{
    const Vec3 center = centroid_of(part.corners);
    const Vec3 local = center - origin_;
    // A point of the part is within the radius of the centroid, so no farther than that from B.
    const double more = 2 * radius_about(center, part.corners) + pair_.rounding(part.cuts);
    double within = part.reach(center) + more;
    near_.clear();
    center_distances_.clear();
    near_.reserve(most_rows);
    center_distances_.reserve(most_rows);
    bool is_full = false;
    visit_near(pair_.b(), {center, center}, within * within, [&](RowRange range) noexcept {
        for (std::uint32_t row = range.first; row < range.first + range.count; ++row) {
            const RowTriangle near(pair_.b().triangle(row), origin_, row, edges_of(pair_.b(), row));
            const double distance = near.distance(local);
            if (!(distance <= within)) continue;
            within = std::min(within, distance + more);
            if (near_.size() == most_rows) drop_far(within);
            is_full = near_.size() == most_rows;
            if (is_full) return -1.0;
            near_.push_back(near);
            center_distances_.push_back(distance);
        }
        return within * within;
    });
    drop_far(within);
    return !is_full && !near_.empty();
}

void NearPieces::drop_far(double within) noexcept
{
    std::size_t kept = 0;
    for (std::size_t i = 0; i < near_.size(); ++i) {
        if (!(center_distances_[i] <= within)) continue;
        near_[kept] = near_[i];
        center_distances_[kept++] = center_distances_[i];
    }
    near_.erase(near_.begin() + static_cast<std::ptrdiff_t>(kept), near_.end());
    center_distances_.resize(kept);
}

SplitPiece NearPieces::split(const NearPiece& piece)
{
    const auto [from, share] = choose_cut(piece);
    const std::size_t to = next_corner(from);
    const Vec3 point = piece.corners[from] + share * (piece.corners[to] - piece.corners[from]);
    const auto first_foot = static_cast<std::uint32_t>(feet_.size());
    for (std::size_t i = 0; i < piece.row_count; ++i)
        feet_.push_back(near_[rows_[piece.first_row + i].near].foot(point));
    SplitPiece result{.parts = {piece, piece}, .corner = to};
    for (std::size_t i = 0; i < 2; ++i) {
        NearPiece& part = result.parts[i];
        const std::size_t corner = i == 0 ? to : from;
        const std::size_t first = rows_.size();
        part.corners[corner] = point;
        part.weight = piece.weight * (i == 0 ? share : 1 - share);
        part.cuts = piece.cuts + 1;
        for (std::uint32_t k = 0; k < piece.row_count; ++k) {
            PieceRow row = rows_[piece.first_row + k];
            row.feet[corner] = first_foot + k;
            rows_.push_back(row);
        }
        bound(part, first, piece.row_count);
    }
    return result;
}

double NearPieces::upper(const NearPiece& piece) const noexcept
{
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < piece.row_count; ++i) {
        const PieceRow& row = rows_[piece.first_row + i];
        least = std::min(least, std::max({distance(row, 0), distance(row, 1), distance(row, 2)}));
    }
    return least;
}

MeasuredPart NearPieces::part(const NearPiece& piece) const noexcept
{
    MeasuredPart part{
        .corners = piece.corners, .nearest = {}, .weight = piece.weight, .cuts = piece.cuts + 1};
    for (Vec3& corner : part.corners) corner += origin_;
    for (std::size_t i = 0; i < piece.row_count; ++i) {
        const PieceRow& row = rows_[piece.first_row + i];
        for (std::size_t k = 0; k < 3; ++k) {
            if (distance(row, k) < part.nearest[k].distance)
                part.nearest[k] = {distance(row, k), near_[row.near].row()};
        }
    }
    // Rows that were left out may be nearer.
    for (std::size_t k = 0; k < 3; ++k)
        part.nearest[k] = pair_.nearest(part.corners[k], part.nearest[k].distance);
    return part;
}

/// A row's distance from below, linear, and by how much it may be closer than what is above.
struct NearPieces::RowBounds {
    CornerValues below{};
    double missing = HUGE_VAL; ///< at the corner where it is most
    double total = -HUGE_VAL;  ///< what is missing at all corners, negative

    void offer(const NearPiece& piece, const TriangleFoot& foot) noexcept
    {
        RowBounds other;
        other.missing = other.total = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            other.below[k] = foot.below(piece.corners[k]);
            const double misses = std::max(piece.above[k] - other.below[k], 0.0);
            other.missing = std::max(other.missing, misses);
            other.total -= misses;
        }
        if (other.total > total) *this = other;
    }
};

NearPieces::RowBounds NearPieces::bounds_of(const NearPiece& piece, const PieceRow& row,
                                            double slack) const noexcept
{
    std::array<const TriangleFoot*, 3> feet{};
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        feet[k] = &feet_[row.feet[k]];
        if (feet[k]->distance - piece.above[k] < feet[nearest]->distance - piece.above[nearest])
            nearest = k;
    }
    RowBounds bounds;
    bounds.offer(piece, *feet[nearest]);
    if (bounds.missing > slack) {
        const Vec3 mean = feet[0]->direction + feet[1]->direction + feet[2]->direction;
        bounds.offer(piece, near_[row.near].slab(mean));
    }
    return bounds;
}

/// Bounds a piece that has the last rows, and leaves out those that it needs not.
void NearPieces::bound(NearPiece& piece, std::size_t first, std::size_t count)
{
    std::size_t lowest = first;
    double least = HUGE_VAL;
    for (std::size_t i = first; i < first + count; ++i) {
        const CornerValues distances = {distance(rows_[i], 0), distance(rows_[i], 1),
                                        distance(rows_[i], 2)};
        if (!(corner_sum(distances) < least)) continue;
        least = corner_sum(distances);
        lowest = i;
        piece.above = distances;
    }
    std::swap(rows_[first], rows_[lowest]);

    const double slack = doubt_ / 64;
    piece.below.fill(HUGE_VAL);
    double lost = 0;
    std::size_t kept = first;
    for (std::size_t i = first; i < first + count; ++i) {
        const PieceRow row = rows_[i];
        const RowBounds bounds = bounds_of(piece, row, slack);
        if (i != first && bounds.missing <= slack) {
            lost = std::max(lost, bounds.missing);
            continue;
        }
        rows_[kept++] = row;
        for (std::size_t k = 0; k < 3; ++k)
            piece.below[k] = std::min(piece.below[k], bounds.below[k]);
    }
    rows_.resize(kept);
    piece.first_row = static_cast<std::uint32_t>(first);
    piece.row_count = static_cast<std::uint32_t>(kept - first);
    piece.lost += lost;
    for (double& value : piece.below) value -= piece.lost;
}

NearPieces::Cut NearPieces::choose_cut(const NearPiece& piece) const noexcept
{
    Cut cut{.side = longest_side_of(piece.corners), .share = 0.5};
    // Halves now and then, so that pieces become small whatever the other cuts do.
    if (piece.cuts % 8 == 7) return cut;
    constexpr double least_share = 0.01;
    const auto propose = [&](std::size_t side, double share) {
        if (!(share > least_share && share < 1 - least_share)) return false;
        cut = {side, share};
        return true;
    };
    const Side worst = worst_side(piece);
    if (worst.conflict > doubt_ / 16 && propose(worst.side, change(piece, worst.side))) return cut;
    if (*std::ranges::min_element(piece.below) >= 0) return cut;
    const PieceRow& row = rows_[piece.first_row];
    double most = 0;
    for (std::size_t from = 0; from < 3; ++from) {
        const double one = feet_[row.feet[from]].height;
        const double other = feet_[row.feet[next_corner(from)]].height;
        if (!(one * other < 0) || !(std::abs(one - other) > most)) continue;
        if (propose(from, one / (one - other))) most = std::abs(one - other);
    }
    return cut;
}

NearPieces::Side NearPieces::worst_side(const NearPiece& piece) const noexcept
{
    CornerValues least;
    least.fill(HUGE_VAL);
    for (std::size_t i = 0; i < piece.row_count; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            least[k] = std::min(least[k], distance(rows_[piece.first_row + i], k));
    }
    Side worst;
    for (std::size_t from = 0; from < 3; ++from) {
        const std::size_t to = next_corner(from);
        double conflict = HUGE_VAL;
        for (std::size_t i = 0; i < piece.row_count; ++i) {
            const PieceRow& row = rows_[piece.first_row + i];
            conflict = std::min(conflict, std::max(distance(row, from) - least[from],
                                                   distance(row, to) - least[to]));
        }
        if (conflict > worst.conflict) worst = {from, conflict};
    }
    return worst;
}

/// The row closest to a corner; of those that are about as near, the one that is nearest to the other.
const NearPieces::PieceRow& NearPieces::closest_at(const NearPiece& piece, std::size_t corner,
                                                   std::size_t other) const noexcept
{
    const double slack = doubt_ / 64;
    const PieceRow* best = &rows_[piece.first_row];
    for (std::size_t i = 1; i < piece.row_count; ++i) {
        const PieceRow& row = rows_[piece.first_row + i];
        const double nearer = distance(*best, corner) - distance(row, corner);
        if (nearer > slack || (nearer > -slack && distance(row, other) < distance(*best, other)))
            best = &row;
    }
    return *best;
}

/// Where on a side the closest row changes, as part of the way; outside of it where that is not known.
/// Of several such places it is the one closest to the middle.
double NearPieces::change(const NearPiece& piece, std::size_t from) const noexcept
{
    const std::size_t to = next_corner(from);
    double best = -1;
    for (std::size_t i = 0; i < piece.row_count; ++i) {
        const double share = leaving(piece, rows_[piece.first_row + i], from, to);
        if (share > 0 && std::abs(share - 0.5) < std::abs(best - 0.5)) best = share;
    }
    if (best > 0) return best;
    const PieceRow& one = closest_at(piece, from, to);
    const PieceRow& other = closest_at(piece, to, from);
    const double at_from = distance(other, from) - distance(one, from);
    const double at_to = distance(one, to) - distance(other, to);
    return at_from / (at_from + at_to);
}

/// Where a side leaves the points above a row's inside, as part of the way: negative where it does not.
/// Between the row and the next the change is in the plane that halves their angle.
double NearPieces::leaving(const NearPiece& piece, const PieceRow& row, std::size_t from,
                           std::size_t to) const noexcept
{
    const RowTriangle& triangle = near_[row.near];
    double first = 2;
    std::size_t side = 3;
    const auto root = [&](std::size_t i, const Vec3& normal) {
        return falling_root(normal.dot(piece.corners[from] - triangle.corner(i)),
                            normal.dot(piece.corners[to] - triangle.corner(i)));
    };
    for (std::size_t i = 0; i < 3; ++i) {
        const double at = root(i, triangle.inward(i));
        if (!(at > 0 && at < first)) continue;
        first = at;
        side = i;
    }
    if (side == 3) return -1;
    const double between = root(side, across(piece, triangle, side));
    return between > 0 ? between : first;
}

/// Normal to the plane that halves the angle between a triangle and the next across a side, towards the
/// first; 0 where the piece has no next.
Vec3 NearPieces::across(const NearPiece& piece, const RowTriangle& triangle,
                        std::size_t side) const noexcept
{
    for (std::size_t i = 0; i < piece.row_count; ++i) {
        const RowTriangle& other = near_[rows_[piece.first_row + i].near];
        if (&other == &triangle) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            if (other.edges()[k] == triangle.edges()[side])
                return triangle.inward(side).normalized() - other.inward(k).normalized();
        }
    }
    return Vec3::Zero();
}

} // namespace proxima
