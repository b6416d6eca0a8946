#include "query/distance/distance_search.h"

#include "geometry/length.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_distance.h"
#include "index/index_parts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace proxima {

namespace {

/// The number of a row's triangle, and the triangle.
struct IndexedTriangle {
    TriangleId id;
    Triangle triangle;
};
IndexedTriangle row_of(const IndexParts& index, std::uint32_t row) noexcept
{
    return {index.id(row), index.triangle(row)};
}

constexpr double single_roundoff = 0x1p-24;

Triangle scaled(const Triangle& triangle, double unit) noexcept
{
    return {{Vec3(triangle[0] * unit), Vec3(triangle[1] * unit), Vec3(triangle[2] * unit)}};
}

/// A power of two that takes a length to where squares of it, and of what is far smaller, are safe;
/// 1 where they are.
double safe_unit(double length) noexcept
{
    constexpr int safe = 300;
    constexpr int most = 1000; // so that 1 / unit is a double, too
    const int exponent = length > 0 && std::isfinite(length) ? std::ilogb(length) : most;
    if (std::abs(exponent) <= safe) return 1;
    return std::ldexp(1.0, std::clamp(-exponent, -most, most));
}

} // namespace

// How far bounds may be above the distances of what they are bounds of, in units of the frame. Let
// u be the roundoff of lanes, and every point within r of A's center, on each axis.
// - Boxes are drawn out by 20 u of floats when the index is made, of which the vertices' rounding
//   to floats and that of centers and half extents, read from bytes, take less than 8 u.
// - The difference d of two centers takes R c, where |c| <= 1.8, the offset, and two sums: 5 u 1.8
// +
//   3 u r on each axis. A gap along an axis of A's takes that and the reach of B's box, 5 u 1.8.
// - Along an axis of B's, R^T d takes 3^(1/2) times the error of d, and 5 u |d|: 16 u + 14 u r;
// that
//   R is a rotation but for 1e-9 takes less than u / 32 |d| in floats, and doubles leave these axes
//   out. A gap takes 10 u more, and the length of three gaps is off by 3^(1/2) times as much.
// - Along d itself (|d|^2 - reaches) / |d| takes less than 2 (|d| 6 u + error of d).
// - A leaf's vertices, moved, are off by 9 u + 3 u r, and their projections by 2 (16 u + 12 u r).
// All of them are below 128 u + 64 u r. To that come the vertices of leaves, floats in any case,
// and what moving vertices and the offset round in doubles: in all, 2^-50 of the coordinates.
DistanceSearch::DistanceSearch(const IndexParts& index_a, const IndexParts& index_b,
                               const RigidTransform& pose_b, double farthest) noexcept
    : a(index_a), b(index_b), rotation(pose_b.rotation), pose_b_(pose_b),
      scale_(std::min(index_a.scale(), index_b.scale())),
      best_squared_(std::numeric_limits<double>::infinity()), farthest_(farthest)
{
    a_scale = static_cast<float>(scale_ / index_a.scale());
    b_scale = static_cast<float>(scale_ / index_b.scale());
    offset = (pose_b(index_b.center()) - index_a.center()) * scale_;
    reach_ = offset.cwiseAbs().maxCoeff() + 2;
    const double coordinates = index_a.center().cwiseAbs().maxCoeff() +
                               2 * index_b.center().cwiseAbs().maxCoeff() +
                               pose_b.translation.cwiseAbs().maxCoeff();
    const double lane_roundoff = needs_doubles() ? 0x1p-53 : single_roundoff;
    margin_ = (128 + 64 * reach_) * lane_roundoff + 8 * single_roundoff +
              0x1p-50 * (scale_ * coordinates + 2);
    const Vec3 between = pose_b(index_b.triangle(0)[0]) - index_a.triangle(0)[0];
    unit_ = safe_unit(
        std::max({block_unit(index_a), block_unit(index_b), between.cwiseAbs().maxCoeff()}));
    lower_limit(farthest * scale_);
}

void DistanceSearch::lower_limit(double distance) noexcept
{
    // Far away bounds are right to 2^-48 of the distance, and so will the answer be.
    const double limit = reach_ > far_reach ? distance - 0x1p-47 * reach_ : distance + margin_;
    limit_ = std::min(limit_, limit);
}

bool DistanceSearch::ask(std::uint32_t row_a, std::uint32_t row_b) noexcept
{
    if (row_a >= a.triangle_count() || row_b >= b.triangle_count()) return false;
    const IndexedTriangle first = row_of(a, row_a);
    const IndexedTriangle second = row_of(b, row_b);
    const Triangle moved = pose_b_(second.triangle);
    const ClosestTrianglePoints pair =
        closest_points(scaled(first.triangle, unit_), scaled(moved, unit_));
    // Where doubles end, what does not touch keeps a distance.
    const bool touch = pair.squared_distance == 0 && triangles_meet(first.triangle, moved);
    const double distance = touch ? 0
                                  : std::max(std::sqrt(pair.squared_distance) / unit_,
                                             std::numeric_limits<double>::denorm_min());
    if (!(distance <= farthest_)) return false;
    // By the distance, too: where squares vanish, only this tells what touches.
    const auto order = [](double squared, double apart, TriangleId id_a, TriangleId id_b) {
        return std::tuple(squared, apart, id_a, id_b);
    };
    if (found_ && order(pair.squared_distance, distance, first.id, second.id) >=
                      order(best_squared_, best_.distance, best_.triangle_a, best_.triangle_b))
        return false;
    found_ = true;
    best_squared_ = pair.squared_distance;
    best_ = {distance,  pair.first.point / unit_, pair.second.point / unit_, first.id,
             second.id, pair.first.part,          pair.second.part,          row_a,
             row_b};
    if (distance > 0) direction_ = unit_of(pair.second.point - pair.first.point);
    lower_limit(distance * scale_);
    return distance == 0;
}

bool DistanceSearch::note(const NotedPair& pair, const Vec3& nearest) noexcept
{
    if (kept_ != nullptr) {
        NearRowsAnswer& answer = kept_->answer;
        answer.complete = answer.count < kept_->rows.size();
        if (answer.complete) kept_->rows[answer.count++] = {pair.row_a, pair.row_b, nearest};
        return !answer.complete;
    }
    if (pair.least <= margin_) return ask(pair.row_a, pair.row_b);
    if (noted_count_ == most_noted && settle()) return true;
    noted_[noted_count_++] = pair;
    // Points that lanes found are as far apart as they say, but for as much as bounds are off.
    const double limit = limit_;
    lower_limit(pair.most + margin_);
    if (limit_ < limit) direction_ = nearest / pair.most;
    return false;
}

bool DistanceSearch::settle() noexcept
{
    const auto begin = noted_.begin();
    const auto end = begin + static_cast<std::ptrdiff_t>(noted_count_);
    noted_count_ = 0;
    std::sort(begin, end, [](const NotedPair& p, const NotedPair& q) { return p.least < q.least; });
    for (auto pair = begin; pair != end && pair->least <= limit_; ++pair)
        if (ask(pair->row_a, pair->row_b)) return true;
    return false;
}

} // namespace proxima
