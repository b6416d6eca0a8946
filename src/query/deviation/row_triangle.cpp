#include "query/deviation/row_triangle.h"

#include "geometry/closest_point.h"

#include <algorithm>
#include <cmath>

namespace proxima {

namespace {

/// Below this share of the longest side, squared, a height is left to the careful closest_point().
constexpr double thin = 1e-8;

} // namespace

std::array<std::uint32_t, 3> edges_of(const IndexParts& index, std::uint32_t row) noexcept
{
    const auto ids = [](const auto& of) {
        return std::array{of.edges[0], of.edges[1], of.edges[2]};
    };
    return index.double_rows().empty() ? ids(index.float_rows()[row])
                                       : ids(index.double_rows()[row]);
}

RowTriangle::RowTriangle(const Triangle& triangle, const Vec3& origin, std::uint32_t row,
                         const std::array<std::uint32_t, 3>& edges) noexcept
    : corners_{triangle[0] - origin, triangle[1] - origin, triangle[2] - origin},
      u_(corners_[1] - corners_[0]), w_(corners_[2] - corners_[0]), uu_(u_.squaredNorm()),
      uw_(u_.dot(w_)), ww_(w_.squaredNorm()), row_(row), edges_(edges)
{
    const Vec3 cross = u_.cross(w_);
    const double squared = cross.squaredNorm();
    const double longest = std::max({uu_, ww_, (w_ - u_).squaredNorm()});
    is_thin_ = !(squared > thin * longest * longest);
    if (!is_thin_) normal_ = cross / std::sqrt(squared);
}

/// The closest point by Voronoi regions ([ericson-2005] 5.1.5).
RowTriangle::Closest RowTriangle::closest(const Vec3& p) const noexcept
{
    if (is_thin_) return {closest_point(Triangle{corners_}, p).point, false};
    const Vec3 x = p - corners_[0];
    const double xu = u_.dot(x);
    const double xw = w_.dot(x);
    if (xu <= 0 && xw <= 0) return {corners_[0], false};
    const double yu = xu - uu_; // from corner 1
    const double yw = xw - uw_;
    if (yu >= 0 && yw <= yu) return {corners_[1], false};
    const double at_2 = xu * yw - yu * xw;
    if (at_2 <= 0 && xu >= 0 && yu <= 0) return {corners_[0] + (xu / uu_) * u_, false};
    const double zu = xu - uw_; // from corner 2
    const double zw = xw - ww_;
    if (zw >= 0 && zu <= zw) return {corners_[2], false};
    const double at_1 = zu * xw - xu * zw;
    if (at_1 <= 0 && xw >= 0 && zw <= 0) return {corners_[0] + (xw / ww_) * w_, false};
    const double at_0 = yu * zw - zu * yw;
    if (at_0 <= 0 && yw >= yu && zu >= zw) {
        const double part = (yw - yu) / ((yw - yu) + (zu - zw));
        return {corners_[1] + part * (corners_[2] - corners_[1]), false};
    }
    // Rounding must not put the point outside.
    const double first = std::max(at_1, 0.0);
    const double second = std::max(at_2, 0.0);
    const double all = std::max(at_0, 0.0) + first + second;
    if (!(all > 0)) return {corners_[0], false};
    return {corners_[0] + (first / all) * u_ + (second / all) * w_, true};
}

void RowTriangle::set_support(TriangleFoot& foot) const noexcept
{
    foot.support = std::max({foot.direction.dot(corners_[0]), foot.direction.dot(corners_[1]),
                             foot.direction.dot(corners_[2])});
}

TriangleFoot RowTriangle::foot(const Vec3& p) const noexcept
{
    const Closest nearest = closest(p);
    const Vec3 way = p - nearest.point;
    TriangleFoot foot;
    foot.distance = way.norm();
    foot.height = normal_.dot(p - corners_[0]);
    if (nearest.is_inside) {
        foot.direction = foot.height < 0 ? Vec3(-normal_) : normal_;
    } else if (foot.distance > 0) {
        foot.direction = way / foot.distance;
    }
    set_support(foot);
    return foot;
}

TriangleFoot RowTriangle::slab(const Vec3& direction) const noexcept
{
    TriangleFoot foot;
    const double length = direction.norm();
    if (length > 0) foot.direction = direction / length;
    set_support(foot);
    return foot;
}

Vec3 RowTriangle::inward(std::size_t side) const noexcept
{
    return normal_.cross(corners_[(side + 1) % 3] - corners_[side]);
}

} // namespace proxima
