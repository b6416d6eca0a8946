#include "query/deviation/mean_piece.h"

#include "index/visit_near.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr std::size_t following(std::size_t corner) noexcept
{
    return corner == 2 ? 0 : corner + 1;
}

double sum_of(const std::array<double, 3>& values) noexcept
{
    return values[0] + values[1] + values[2];
}

/// The mean of the square of a linear function over a triangle, by its values at the corners.
double mean_of_squares(const std::array<double, 3>& values) noexcept
{
    const double sum = sum_of(values);
    const double squares = values[0] * values[0] + values[1] * values[1] + values[2] * values[2];
    return (squares + sum * sum) / 12;
}

double radius_about(const Vec3& center, const std::array<Vec3, 3>& corners) noexcept
{
    double most = 0;
    for (const Vec3& corner : corners) most = std::max(most, (corner - center).squaredNorm());
    return std::sqrt(most);
}

Vec3 centroid_of(const std::array<Vec3, 3>& corners) noexcept
{
    return (corners[0] + corners[1] + corners[2]) / 3;
}

struct LongestSide {
    std::size_t side = 0;
    double squared = -1;
};

LongestSide longest_side_of(const std::array<Vec3, 3>& corners) noexcept
{
    LongestSide longest;
    for (std::size_t i = 0; i < 3; ++i) {
        const double squared = (corners[following(i)] - corners[i]).squaredNorm();
        if (squared > longest.squared) longest = {i, squared};
    }
    return longest;
}

void set_bounds(MeanPiece& piece, const std::array<double, 3>& below) noexcept
{
    piece.mean_upper = sum_of(piece.above) / 3;
    piece.squares_upper = mean_of_squares(piece.above);
    piece.mean_lower = std::clamp(sum_of(below) / 3, 0.0, piece.mean_upper);
    // Where it is below 0 somewhere its square says nothing, but that of the mean does.
    const bool is_positive = *std::ranges::min_element(below) >= 0;
    const double squares =
        is_positive ? mean_of_squares(below) : piece.mean_lower * piece.mean_lower;
    piece.squares_lower = std::min(squares, piece.squares_upper);
}

} // namespace

MeanPiece MeanPieces::whole(std::uint32_t row_a, const std::array<NearestRow, 3>& nearest)
{
    rows_.clear();
    MeanPiece piece{.corners = pair_.a().triangle(row_a).vertices, .nearest = nearest};
    bound(piece);
    return piece;
}

std::array<MeanPiece, 2> MeanPieces::split(const MeanPiece& piece)
{
    const std::size_t from = piece.side;
    const std::size_t to = following(from);
    const Vec3 point = piece.corners[from] + piece.part * (piece.corners[to] - piece.corners[from]);
    NearestRow nearest;
    if (!piece.has_rows()) {
        double known = HUGE_VAL;
        for (std::size_t i = 0; i < 3; ++i) {
            known = std::min(known, piece.nearest[i].distance + (point - piece.corners[i]).norm());
        }
        nearest = pair_.nearest(point, known);
    }
    std::array<MeanPiece, 2> parts = {piece, piece};
    for (std::size_t i = 0; i < 2; ++i) {
        const std::size_t corner = i == 0 ? to : from;
        parts[i].corners[corner] = point;
        parts[i].nearest[corner] = nearest;
        parts[i].weight = piece.weight * (i == 0 ? piece.part : 1 - piece.part);
        parts[i].cuts = piece.cuts + 1;
        bound(parts[i]);
    }
    return parts;
}

void MeanPieces::bound(MeanPiece& piece)
{
    if (piece.has_rows()) {
        bound_by_rows(piece);
        return;
    }
    bound_without_rows(piece);
    if (piece.mean_upper - piece.mean_lower > doubt_ && collect_rows(piece)) bound_by_rows(piece);
}

std::array<double, 3> MeanPieces::distances(const MeanPiece& piece,
                                            std::uint32_t row) const noexcept
{
    return {pair_.distance(piece.corners[0], row), pair_.distance(piece.corners[1], row),
            pair_.distance(piece.corners[2], row)};
}

void MeanPieces::bound_without_rows(MeanPiece& piece) const
{
    double least = HUGE_VAL;
    for (const NearestRow& nearest : piece.nearest) {
        const auto above = distances(piece, nearest.row);
        if (!(sum_of(above) < least)) continue;
        least = sum_of(above);
        piece.above = above;
    }
    const LongestSide longest = longest_side_of(piece.corners);
    const double variance = longest.squared / 3;
    std::array<double, 3> below{};
    for (std::size_t i = 0; i < 3; ++i) {
        // The distance may be too large by its rounding, of which the root near 0 makes more.
        const double distance = piece.nearest[i].distance;
        const double squared =
            distance * distance - variance - 2 * distance * pair_.rounding(piece.cuts);
        if (squared < 0) {
            below = {};
            break;
        }
        below[i] = std::sqrt(squared);
    }
    set_bounds(piece, below);
    piece.side = static_cast<std::uint8_t>(longest.side);
    piece.part = 0.5;
}

/// All rows that may be closest to a point of the piece; false and none where they are too many.
bool MeanPieces::collect_rows(MeanPiece& piece)
{
    const Vec3 center = centroid_of(piece.corners);
    const double radius = radius_about(center, piece.corners);
    double reach = HUGE_VAL; // from the centroid to B, at most
    for (std::size_t i = 0; i < 3; ++i) {
        reach = std::min(reach, piece.nearest[i].distance + (center - piece.corners[i]).norm());
    }
    // A point of the piece is within `radius` of the centroid and no farther from B than the upper
    // bound at some corner.
    const double most = *std::ranges::max_element(piece.above);
    const double within = std::min(reach + 2 * radius, most + radius) + pair_.rounding(piece.cuts);
    piece.first_row = rows_.size();
    rows_.reserve(rows_.size() + most_rows);
    bool is_full = false;
    visit_near(pair_.b(), {center, center}, within * within, [&](RowRange range) noexcept {
        for (std::uint32_t row = range.first; row < range.first + range.count; ++row) {
            if (!(pair_.distance(center, row) <= within)) continue;
            is_full = rows_.size() - piece.first_row == most_rows;
            if (is_full) return -1.0;
            rows_.push_back(row);
        }
        return within * within;
    });
    if (is_full) {
        rows_.resize(piece.first_row);
        return false;
    }
    piece.row_count = static_cast<std::uint32_t>(rows_.size() - piece.first_row);
    return piece.row_count != 0;
}

void MeanPieces::bound_by_rows(MeanPiece& piece)
{
    const Vec3 center = centroid_of(piece.corners);
    const double radius = radius_about(center, piece.corners);
    std::array<double, 3> below;
    below.fill(HUGE_VAL);
    std::array<std::size_t, 3> lowest{};
    std::size_t closest = 0;
    tangents_.resize(piece.row_count);
    for (std::size_t i = 0; i < piece.row_count; ++i) {
        Tangent& tangent = tangents_[i];
        tangent.row = rows_[piece.first_row + i];
        const Vec3 way = center - closest_point(pair_.b().triangle(tangent.row), center).point;
        tangent.distance = way.norm();
        if (tangent.distance < tangents_[closest].distance) closest = i;
        // The way is off by roundings of the diagonal and of coordinates. The plane through 0 is below as well.
        const double turned = pair_.way_rounding() / tangent.distance;
        const bool is_flat = !(turned < 0x1p-18);
        for (std::size_t k = 0; k < 3; ++k) {
            tangent.corners[k] = is_flat
                                     ? 0
                                     : tangent.distance - turned * radius +
                                           way.dot(piece.corners[k] - center) / tangent.distance;
            if (!(tangent.corners[k] < below[k])) continue;
            below[k] = tangent.corners[k];
            lowest[k] = i;
        }
    }
    double least = HUGE_VAL;
    for (const std::size_t i : {closest, lowest[0], lowest[1], lowest[2]}) {
        const auto above = distances(piece, tangents_[i].row);
        if (!(sum_of(above) < least)) continue;
        least = sum_of(above);
        piece.above = above;
    }
    set_bounds(piece, below);
    choose_cut(piece, below, lowest);
    const std::size_t first = rows_.size();
    // Both the tangent, lowered by its turn, and what is above are off.
    const double slack = 2 * pair_.rounding(piece.cuts);
    for (const Tangent& tangent : tangents_) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (tangent.corners[k] > piece.above[k] + slack) continue;
            rows_.push_back(tangent.row);
            break;
        }
    }
    piece.first_row = first;
    piece.row_count = static_cast<std::uint32_t>(rows_.size() - first);
}

/// Where the surfaces cross, where the closest row changes, or in the middle of the longest side.
void MeanPieces::choose_cut(MeanPiece& piece, const std::array<double, 3>& below,
                            const std::array<std::size_t, 3>& lowest) const
{
    piece.side = static_cast<std::uint8_t>(longest_side_of(piece.corners).side);
    piece.part = 0.5;
    if (piece.cuts % 4 == 3) return;
    constexpr double least_part = 0.01;
    const auto propose = [&](std::size_t side, double part) {
        if (!(part > least_part && part < 1 - least_part)) return;
        piece.side = static_cast<std::uint8_t>(side);
        piece.part = part;
    };
    double most = 0;
    for (std::size_t from = 0; from < 3; ++from) {
        const std::size_t to = following(from);
        if ((below[from] < 0) != (below[to] < 0)) {
            const double step = std::abs(below[from]) + std::abs(below[to]);
            if (step > most) propose(from, std::abs(below[from]) / step);
            most = std::max(most, step);
        } else if (lowest[from] != lowest[to]) {
            const Tangent& one = tangents_[lowest[from]];
            const Tangent& other = tangents_[lowest[to]];
            const double at_from = other.corners[from] - one.corners[from];
            const double at_to = one.corners[to] - other.corners[to];
            if (at_from + at_to > most) propose(from, at_from / (at_from + at_to));
            most = std::max(most, at_from + at_to);
        }
    }
}

} // namespace proxima
