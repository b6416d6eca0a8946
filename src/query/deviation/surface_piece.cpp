#include "query/deviation/surface_piece.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

constexpr std::size_t next_of(std::size_t corner) noexcept
{
    return corner == 2 ? 0 : corner + 1;
}

/// A cut so near to a corner makes hardly any progress.
constexpr double least_part = 1e-4;

} // namespace

SurfacePiece::SurfacePiece(const SurfacePair& pair, std::uint32_t row_a,
                           const std::array<NearestRow, 3>& nearest) noexcept
    : corners_(pair.a().triangle(row_a).vertices), row_a_(row_a)
{
    for (std::size_t i = 0; i < 3; ++i) {
        nearest_[i] = nearest[i].distance;
        std::size_t at = 0;
        while (at < count_ && rows_[at] != nearest[i].row) ++at;
        own_[i] = static_cast<std::uint8_t>(at);
        if (at < count_) continue;
        rows_[at] = nearest[i].row;
        for (std::size_t k = 0; k < 3; ++k)
            distances_[at][k] = pair.distance(corners_[k], rows_[at]);
        ++count_;
    }
    bound();
}

void SurfacePiece::bound() noexcept
{
    upper_ = HUGE_VAL;
    for (std::size_t i = 0; i < count_; ++i)
        upper_ = std::min(upper_, *std::ranges::max_element(distances_[i]));
}

double SurfacePiece::reach_of(const Vec3& p) const noexcept
{
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i)
        least = std::min(least, nearest_[i] + (p - corners_[i]).norm());
    return least;
}

void SurfacePiece::add_row(const SurfacePair& pair, std::uint32_t row) noexcept
{
    for (std::size_t i = 0; i < count_; ++i)
        if (rows_[i] == row) return;
    // Whole triangles have three rows at most: there is a place.
    rows_[count_] = row;
    for (std::size_t k = 0; k < 3; ++k) distances_[count_][k] = pair.distance(corners_[k], row);
    ++count_;
    bound();
}

bool SurfacePiece::is_of_b(const SurfacePair& pair) const noexcept
{
    if (cuts_ != 0 || upper_ != 0 || !pair.is_exact()) return false;
    for (std::size_t i = 0; i < count_; ++i) {
        const Triangle other = pair.b().triangle(rows_[i]);
        const auto has = [&](const Vec3& corner) {
            return std::ranges::find(other.vertices, corner) != other.vertices.end();
        };
        if (std::ranges::all_of(corners_, has)) return true;
    }
    return false;
}

std::size_t SurfacePiece::longest_side() const noexcept
{
    std::size_t longest = 0;
    double most = -1;
    for (std::size_t i = 0; i < 3; ++i) {
        const double squared = (corners_[next_of(i)] - corners_[i]).squaredNorm();
        if (!(squared > most)) continue;
        most = squared;
        longest = i;
    }
    return longest;
}

SurfacePiece::Side SurfacePiece::side_of(std::size_t side) const noexcept
{
    Side result{.side = side, .conflict = HUGE_VAL, .common = 0};
    const std::size_t to = next_of(side);
    for (std::size_t i = 0; i < count_; ++i) {
        const double excess =
            std::max(distances_[i][side] - nearest_[side], distances_[i][to] - nearest_[to]);
        if (!(excess < result.conflict)) continue;
        result.conflict = excess;
        result.common = i;
    }
    return result;
}

/// Where on a side the closest rows of its ends are as near as each other, as part of the way. By
/// Newton's method for the squared distances, whose gradients are twice the ways from the feet.
double SurfacePiece::point_between(const SurfacePair& pair, std::size_t side,
                                   double slack) const noexcept
{
    const std::size_t to = next_of(side);
    const Triangle first = pair.b().triangle(rows_[own_[side]]);
    const Triangle second = pair.b().triangle(rows_[own_[to]]);
    const Vec3 along = corners_[to] - corners_[side];
    double low = 0;
    double high = 1;
    const double at_start = distances_[own_[to]][side] - distances_[own_[side]][side];
    const double at_end = distances_[own_[side]][to] - distances_[own_[to]][to];
    double t = at_start / (at_start + at_end);
    for (int step = 0; step < 12; ++step) {
        if (!(t > low && t < high)) t = 0.5 * (low + high);
        const Vec3 p = corners_[side] + t * along;
        const Vec3 one = closest_point(first, p).point;
        const Vec3 other = closest_point(second, p).point;
        const double d1 = (p - one).norm();
        const double d2 = (p - other).norm();
        if (std::abs(d1 - d2) <= slack) break;
        (d1 < d2 ? low : high) = t;
        const double slope = 2 * (other - one).dot(along);
        t = slope > 0 ? t - (d1 - d2) * (d1 + d2) / slope : -1;
    }
    return t;
}

bool SurfacePiece::is_well_inside(const Vec3& point) const noexcept
{
    const Vec3 u = corners_[1] - corners_[0];
    const Vec3 w = corners_[2] - corners_[0];
    const Vec3 x = point - corners_[0];
    const double uu = u.dot(u);
    const double uw = u.dot(w);
    const double ww = w.dot(w);
    const double determinant = uu * ww - uw * uw;
    if (!(determinant > 0)) return false;
    const double b1 = (ww * u.dot(x) - uw * w.dot(x)) / determinant;
    const double b2 = (uu * w.dot(x) - uw * u.dot(x)) / determinant;
    return b1 > least_part && b2 > least_part && 1 - b1 - b2 > least_part;
}

/// Where three rows are as near as each other: by Newton's method, or else below the vertex of B that is
/// nearest, which rows that lie almost in the piece's plane share. False where that is not well inside.
bool SurfacePiece::point_among(const SurfacePair& pair, const std::array<std::uint32_t, 3>& rows,
                               Vec3& point) const noexcept
{
    std::array<Triangle, 3> triangles;
    for (std::size_t i = 0; i < 3; ++i) triangles[i] = pair.b().triangle(rows[i]);
    const Vec3 u = corners_[1] - corners_[0];
    const Vec3 w = corners_[2] - corners_[0];
    Vec3 p = centroid();
    bool converged = false;
    for (int step = 0; step < 8 && !converged; ++step) {
        std::array<Vec3, 3> feet;
        std::array<double, 3> squared{};
        for (std::size_t i = 0; i < 3; ++i) {
            feet[i] = closest_point(triangles[i], p).point;
            squared[i] = (p - feet[i]).squaredNorm();
        }
        const Vec3 g1 = 2 * (feet[1] - feet[0]);
        const Vec3 g2 = 2 * (feet[2] - feet[0]);
        const double f1 = squared[0] - squared[1];
        const double f2 = squared[0] - squared[2];
        const double a = g1.dot(u);
        const double b = g1.dot(w);
        const double c = g2.dot(u);
        const double d = g2.dot(w);
        const double determinant = a * d - b * c;
        if (!(std::abs(determinant) > 1e-10 * (std::abs(a * d) + std::abs(b * c)))) break;
        const double du = (b * f2 - d * f1) / determinant;
        const double dw = (c * f1 - a * f2) / determinant;
        p += du * u + dw * w;
        if (!p.allFinite()) break;
        converged = std::abs(du) + std::abs(dw) < 1e-9;
    }
    point = p;
    if (converged && is_well_inside(p)) return true;
    double least = HUGE_VAL;
    Vec3 vertex = Vec3::Zero();
    for (const Triangle& triangle : triangles) {
        for (const Vec3& corner : triangle.vertices) {
            const double squared = (corner - centroid()).squaredNorm();
            if (!(squared < least)) continue;
            least = squared;
            vertex = corner;
        }
    }
    const Vec3 normal = u.cross(w);
    const double length = normal.squaredNorm();
    if (!(length > 0)) return false;
    point = vertex - (normal.dot(vertex - corners_[0]) / length) * normal;
    return is_well_inside(point);
}

SurfacePiece SurfacePiece::with_corner(std::size_t corner, const Cut& cut,
                                       const std::array<double, most_rows>& at_cut,
                                       const Distances& of_new_row,
                                       double new_at_cut) const noexcept
{
    struct Choice {
        std::uint32_t row = 0;
        Distances distances{};
        double most = 0;
        bool is_own = false;
    };
    std::array<Choice, most_rows + 1> choices;
    std::size_t count = 0;
    bool is_known = false;
    for (std::size_t i = 0; i < count_; ++i) {
        Choice& choice = choices[count++];
        choice = {.row = rows_[i], .distances = distances_[i], .most = 0, .is_own = false};
        choice.distances[corner] = at_cut[i];
        for (std::size_t k = 0; k < 3; ++k)
            choice.is_own = choice.is_own || (k != corner && own_[k] == i);
        if (rows_[i] == cut.nearest.row) choice.is_own = is_known = true;
    }
    if (!is_known) {
        Choice& choice = choices[count++];
        choice = {.row = cut.nearest.row, .distances = of_new_row, .most = 0, .is_own = true};
        choice.distances[corner] = new_at_cut;
    }
    for (std::size_t i = 0; i < count; ++i)
        choices[i].most = *std::ranges::max_element(choices[i].distances);
    std::stable_sort(choices.begin(), choices.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Choice& one, const Choice& other) {
                         if (one.is_own != other.is_own) return one.is_own;
                         return one.most < other.most;
                     });
    SurfacePiece piece;
    piece.corners_ = corners_;
    piece.corners_[corner] = cut.point;
    piece.nearest_ = nearest_;
    piece.nearest_[corner] = cut.nearest.distance;
    piece.cuts_ = cuts_ + 1;
    piece.row_a_ = row_a_;
    piece.count_ = static_cast<std::uint8_t>(std::min(count, most_rows));
    for (std::size_t i = 0; i < piece.count_; ++i) {
        piece.rows_[i] = choices[i].row;
        piece.distances_[i] = choices[i].distances;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t own = k == corner ? cut.nearest.row : rows_[own_[k]];
            if (own == choices[i].row) piece.own_[k] = static_cast<std::uint8_t>(i);
        }
    }
    piece.bound();
    return piece;
}

SurfacePiece::Cut SurfacePiece::split(const SurfacePair& pair, double slack,
                                      std::vector<SurfacePiece>& to) const
{
    std::array<Side, 3> sides;
    Side worst;
    for (std::size_t i = 0; i < 3; ++i) {
        sides[i] = side_of(i);
        if (i == 0 || sides[i].conflict > worst.conflict) worst = sides[i];
    }
    // Halves now and then, so that pieces become small whatever the other cuts do.
    const bool is_halved = cuts_ % 8 == 7;
    std::size_t side = longest_side();
    double t = 0.5;
    Cut cut;
    bool is_inside = false;
    if (!is_halved && worst.conflict > slack) {
        const double between = point_between(pair, worst.side, 0.25 * slack);
        if (between > least_part && between < 1 - least_part) {
            side = worst.side;
            t = between;
        }
    } else if (!is_halved) {
        is_inside = point_among(
            pair, {rows_[sides[0].common], rows_[sides[1].common], rows_[sides[2].common]},
            cut.point);
    }
    if (!is_inside) cut.point = corners_[side] + t * (corners_[next_of(side)] - corners_[side]);
    cut.nearest = pair.nearest(cut.point, reach_of(cut.point));
    std::array<double, most_rows> at_cut{};
    for (std::size_t i = 0; i < count_; ++i) at_cut[i] = pair.distance(cut.point, rows_[i]);
    Distances of_new_row{};
    for (std::size_t k = 0; k < 3; ++k) of_new_row[k] = pair.distance(corners_[k], cut.nearest.row);
    const double new_at_cut = pair.distance(cut.point, cut.nearest.row);
    for (std::size_t corner = 0; corner < 3; ++corner) {
        if (is_inside || corner == side || corner == next_of(side))
            to.push_back(with_corner(corner, cut, at_cut, of_new_row, new_at_cut));
    }
    return cut;
}

} // namespace proxima
