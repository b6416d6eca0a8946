#include "minkowski/triangle_cube_proximity.h"

#include "base/check.h"
#include "geometry/closest_point.h"
#include "geometry/triangle_box.h"
#include "minkowski/triangle_cube_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {
namespace {

constexpr std::size_t at(int index) noexcept
{
    return static_cast<std::size_t>(index);
}

/// A power of two to divide by, in two steps because one may be out of the range of doubles.
class Scale {
public:
    explicit Scale(const Triangle& triangle, const Box& box) noexcept
    {
        Box both = box;
        for (const Vec3& vertex : triangle.vertices) both.extend(vertex);
        // Halves, because a difference of two doubles may overflow.
        const double extent = (0.5 * both.upper - 0.5 * both.lower).maxCoeff();
        if (!(extent > 0)) return;
        int exponent = 0;
        static_cast<void>(std::frexp(extent, &exponent));
        ++exponent;
        const int half = exponent / 2;
        up_ = {std::ldexp(1.0, half), std::ldexp(1.0, exponent - half)};
        down_ = {std::ldexp(1.0, -half), std::ldexp(1.0, half - exponent)};
    }

    /// (a - b), divided: at most 1 for coordinates of triangle and box. What is below 1e-300 may
    /// vanish. An axis on which all is equal may be so far out that division overflows.
    [[nodiscard]] double difference(double a, double b) const noexcept
    {
        return a == b ? 0 : a * down_[0] * down_[1] - b * down_[0] * down_[1];
    }
    [[nodiscard]] Vec3 difference(const Vec3& a, const Vec3& b) const noexcept
    {
        return {difference(a.x(), b.x()), difference(a.y(), b.y()), difference(a.z(), b.z())};
    }
    [[nodiscard]] double multiplied(double length) const noexcept
    {
        return length * up_[0] * up_[1];
    }
    [[nodiscard]] Vec3 multiplied(const Vec3& v) const noexcept { return v * up_[0] * up_[1]; }

private:
    std::array<double, 2> up_ = {1, 1};
    std::array<double, 2> down_ = {1, 1};
};

/// The motions along which a triangle leaves a box. Each number is made of differences of
/// coordinates, rounded once, so that distance from the origin costs no precision.
class Motions {
public:
    Motions(const Triangle& triangle, const Box& box, const Scale& scale) noexcept
    {
        for (int i = 0; i < 3; ++i) {
            from_first_[at(i)] = scale.difference(triangle[i], triangle[0]);
            to_lower_[at(i)] = scale.difference(box.lower, triangle[i]);
            to_upper_[at(i)] = scale.difference(box.upper, triangle[i]);
        }
    }

    /// Calls visit(direction, its length, motion) for each half-space of the sum: a vector along
    /// which the triangle can be moved to be free, and how far.
    template <class Visit>
    void visit_all(Visit visit) const noexcept
    {
        CornerCoordinates<double> corners;
        for (std::size_t i = 0; i < 3; ++i)
            corners[i] = {from_first_[i].x(), from_first_[i].y(), from_first_[i].z()};
        const TriangleCubeSum<double> sum(corners);
        for (int half_space = 0; half_space < triangle_cube_half_spaces; ++half_space) {
            const Triple<double> outward = sum.normal(half_space);
            const Vec3 direction(-outward[0], -outward[1], -outward[2]);
            const double squared_length = direction.squaredNorm();
            if (squared_length < negligible) continue;
            const double length = std::sqrt(squared_length);
            visit(direction, length, std::max(beyond(direction), 0.0) / length);
        }
    }

private:
    /// Squares below lose digits; triangles so small are as good as points, as sizes are about 1.
    static constexpr double negligible = 1e-280;

    /// How far the triangle must move along a direction, times that one's length, until all of it
    /// is beyond the box: the largest, over its vertices, of what parts them from the box's
    /// farthest corner.
    [[nodiscard]] double beyond(const Vec3& direction) const noexcept
    {
        double motion = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            double sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const double component = direction[axis];
                sum += component * (component > 0 ? to_upper_[i][axis] : to_lower_[i][axis]);
            }
            motion = std::max(motion, sum);
        }
        return motion;
    }

    std::array<Vec3, 3> from_first_;
    std::array<Vec3, 3> to_lower_;
    std::array<Vec3, 3> to_upper_;
};

/// Triangle and box as seen from the box's lower corner, scaled.
struct ScaledPair {
    Triangle triangle;
    Box box;

    ScaledPair(const Triangle& given_triangle, const Box& given_box, const Scale& scale) noexcept
        : box{Vec3::Zero(), scale.difference(given_box.upper, given_box.lower)}
    {
        for (int i = 0; i < 3; ++i)
            triangle.vertices[at(i)] = scale.difference(given_triangle[i], given_box.lower);
    }
};

/// Where two shapes overlap and rounding must be kept out: the candidate least far from both.
class CommonPoint {
public:
    explicit CommonPoint(const ScaledPair& pair) noexcept : pair_(pair) {}

    [[nodiscard]] Vec3 find() noexcept
    {
        for (const Vec3& vertex : pair_.triangle.vertices) offer(vertex);
        for (int i = 0; i < 3 && best_distance_ > 0; ++i)
            offer_clipped({pair_.triangle[i], pair_.triangle[(i + 1) % 3]});
        for (int axis = 0; axis < 3 && best_distance_ > 0; ++axis) offer_pierced(axis);
        return best_;
    }

private:
    /// A point of the triangle.
    void offer(const Vec3& point) noexcept
    {
        const Vec3 in_box = point.cwiseMax(pair_.box.lower).cwiseMin(pair_.box.upper);
        const double distance = (in_box - point).squaredNorm();
        if (!(distance < best_distance_)) return;
        best_distance_ = distance;
        best_ = in_box;
    }

    /// The middle of the part of a side that is in the box.
    void offer_clipped(const Segment& side) noexcept
    {
        double enter = 0;
        double leave = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double along = side.to[axis] - side.from[axis];
            if (along == 0) continue;
            const double lower = (pair_.box.lower[axis] - side.from[axis]) / along;
            const double upper = (pair_.box.upper[axis] - side.from[axis]) / along;
            enter = std::max(enter, std::min(lower, upper));
            leave = std::min(leave, std::max(lower, upper));
        }
        offer(side.at(std::clamp(0.5 * (enter + leave), 0.0, 1.0)));
    }

    /// Where the box's edges along an axis meet the triangle's plane.
    void offer_pierced(int axis) noexcept
    {
        const Vec3 normal = scaled_normal(pair_.triangle).stableNormalized();
        if (normal[axis] == 0) return;
        for (int corner = 0; corner < 4; ++corner) {
            const int u = (axis + 1) % 3;
            const int w = (axis + 2) % 3;
            Vec3 point = pair_.box.lower;
            if ((corner & 1) != 0) point[u] = pair_.box.upper[u];
            if ((corner & 2) != 0) point[w] = pair_.box.upper[w];
            const double step = normal.dot(pair_.triangle[0] - point) / normal[axis];
            point[axis] =
                std::clamp(point[axis] + step, pair_.box.lower[axis], pair_.box.upper[axis]);
            offer(closest_point(pair_.triangle, point).point);
        }
    }

    const ScaledPair& pair_;
    Vec3 best_ = Vec3::Zero();
    double best_distance_ = std::numeric_limits<double>::infinity();
};

/// The closest of all pairs of features of a triangle and a box that are apart.
class ClosestFeatures {
public:
    explicit ClosestFeatures(const ScaledPair& pair) noexcept : triangle_(pair.triangle)
    {
        // The box's point closest to any point p of the triangle is p clamped to the box: the rest
        // of the box plays no part. Where the triangle is beyond a side, only that side remains.
        Box around;
        for (const Vec3& vertex : triangle_.vertices) around.extend(vertex);
        box_ = {around.lower.cwiseMax(pair.box.lower).cwiseMin(pair.box.upper),
                around.upper.cwiseMax(pair.box.lower).cwiseMin(pair.box.upper)};
    }

    [[nodiscard]] TriangleBoxSeparation find() noexcept
    {
        for (const Vec3& vertex : triangle_.vertices)
            offer(vertex, vertex.cwiseMax(box_.lower).cwiseMin(box_.upper));
        for (int corner = 0; corner < 8; ++corner) {
            if (is_double(corner)) continue;
            const Vec3 point = box_corner(corner);
            offer(closest_point(triangle_, point).point, point);
        }
        for (int axis = 0; axis < 3; ++axis) {
            for (int corner = 0; corner < 8; ++corner) {
                if ((corner >> axis & 1) != 0 || is_double(corner)) continue;
                offer_edges({box_corner(corner), box_corner(corner | 1 << axis)});
            }
        }
        best_.distance = std::sqrt(best_.distance);
        return best_;
    }

private:
    [[nodiscard]] Vec3 box_corner(int corner) const noexcept
    {
        Vec3 point = box_.lower;
        for (int axis = 0; axis < 3; ++axis) {
            if ((corner >> axis & 1) != 0) point[axis] = box_.upper[axis];
        }
        return point;
    }
    /// Whether the corner is the same as one of a smaller number: on an axis the box is flat.
    [[nodiscard]] bool is_double(int corner) const noexcept
    {
        for (int axis = 0; axis < 3; ++axis) {
            if ((corner >> axis & 1) != 0 && box_.lower[axis] == box_.upper[axis]) return true;
        }
        return false;
    }
    void offer_edges(const Segment& box_edge) noexcept
    {
        if (box_edge.from == box_edge.to) return;
        for (int i = 0; i < 3; ++i) {
            const SegmentPair closest =
                closest_points({triangle_[i], triangle_[(i + 1) % 3]}, box_edge);
            offer(closest.first.point, closest.second.point);
        }
    }
    void offer(const Vec3& on_triangle, const Vec3& on_box) noexcept
    {
        const double squared = (on_triangle - on_box).squaredNorm();
        if (!(squared < best_.distance)) return;
        best_ = {squared, on_triangle, on_box};
    }

    const Triangle& triangle_;
    Box box_;
    TriangleBoxSeparation best_ = {std::numeric_limits<double>::infinity(), Vec3::Zero(),
                                   Vec3::Zero()};
};

} // namespace

std::optional<Penetration> penetration(const Triangle& triangle, const Box& box) noexcept
{
    if (!triangle_overlaps_box(triangle, box)) return std::nullopt;
    const Scale scale(triangle, box);
    Penetration least = {std::numeric_limits<double>::infinity(), Vec3::Zero()};
    const auto keep_least = [&](const Vec3& direction, double /*length*/, double motion) {
        if (motion < least.depth) least = {motion, direction};
    };
    Motions(triangle, box, scale).visit_all(keep_least);
    least.depth = scale.multiplied(least.depth);
    least.direction.normalize();
    return least;
}

std::optional<double> penetration_along(const Triangle& triangle, const Box& box,
                                        const Vec3& direction) noexcept
{
    PROXIMA_CHECK(!direction.isZero(0));
    if (!triangle_overlaps_box(triangle, box)) return std::nullopt;
    const Scale scale(triangle, box);
    const Vec3 along = direction.stableNormalized();
    double least = std::numeric_limits<double>::infinity();
    const auto keep_least = [&](const Vec3& free, double length, double motion) {
        const double progress = free.dot(along);
        if (progress > 0) least = std::min(least, motion * length / progress);
    };
    Motions(triangle, box, scale).visit_all(keep_least);
    return scale.multiplied(least);
}

TriangleBoxSeparation separation(const Triangle& triangle, const Box& box) noexcept
{
    const Scale scale(triangle, box);
    const ScaledPair pair(triangle, box, scale);
    TriangleBoxSeparation result;
    const auto on_box = [&](const Vec3& p) {
        return Vec3((box.lower + scale.multiplied(p)).cwiseMax(box.lower).cwiseMin(box.upper));
    };
    if (triangle_overlaps_box(triangle, box)) {
        result.on_box = on_box(CommonPoint(pair).find());
        result.on_triangle = result.on_box;
        return result;
    }
    result = ClosestFeatures(pair).find();
    result.distance = scale.multiplied(result.distance);
    result.on_triangle = box.lower + scale.multiplied(result.on_triangle);
    result.on_box = on_box(result.on_box);
    return result;
}

} // namespace proxima
