#include "query/contacts/hull_depth.h"

#include "geometry/length.h"
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace proxima {

namespace {

/// A point of A - B, and the points that it is the difference of.
struct DifferencePoint {
    Vec3 difference;
    Vec3 of_a;
};

/// The farthest vertex along a direction, from neighbour to neighbour, from the last one on. What it says is a
/// vertex whatever is rounded.
class SupportWalk {
public:
    SupportWalk(const ConvexPolyhedron& hull, std::span<const Vec3> points)
        : hull_(hull), points_(points)
    {}

    const Vec3& operator()(const Vec3& direction)
    {
        double most = direction.dot(points_[at_]);
        for (bool is_better = true; is_better;) {
            is_better = false;
            for (const PolyhedronNeighbour& next : hull_.neighbours(at_)) {
                const double along = direction.dot(points_[next.vertex]);
                if (!(along > most)) continue;
                most = along;
                at_ = next.vertex;
                is_better = true;
                break;
            }
        }
        return points_[at_];
    }

private:
    const ConvexPolyhedron& hull_;
    std::span<const Vec3> points_;
    std::uint32_t at_ = 0;
};

class DifferenceBody {
public:
    DifferenceBody(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                   std::span<const Vec3> moved_b)
        : a_(a, a.points()), b_(b, moved_b)
    {
        // Unequal weights: the middle of one mesh is often that of the other.
        const Vec3 of_a = middle(a.points(), 3);
        inner_ = {of_a - middle(moved_b, 5), of_a};
    }

    /// Inside, but for rounding.
    [[nodiscard]] const DifferencePoint& inner() const { return inner_; }

    DifferencePoint support(const Vec3& direction)
    {
        const Vec3& of_a = a_(direction);
        return {of_a - b_(-direction), of_a};
    }

private:
    static Vec3 middle(std::span<const Vec3> points, std::size_t period)
    {
        Vec3 sum = Vec3::Zero();
        double weights = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double weight = 1 + 0.125 * static_cast<double>(i % period);
            sum += weight * points[i];
            weights += weight;
        }
        return sum / weights;
    }

    SupportWalk a_;
    SupportWalk b_;
    DifferencePoint inner_;
};

/// Three vertices of the body through which the ray from `inner` through the origin leaves it, farther out than the
/// origin is [snethen-2008]. Nothing where the origin is not found to be inside.
std::optional<std::array<DifferencePoint, 3>> find_portal(DifferenceBody& body, double rounding)
{
    const Vec3 inner = body.inner().difference;
    DifferencePoint p1 = body.support(-inner);
    Vec3 out = p1.difference.cross(inner);
    DifferencePoint p2 = body.support(out);
    out = (p1.difference - inner).cross(p2.difference - inner);
    if (out.dot(inner) > 0) {
        std::swap(p1, p2);
        out = -out;
    }
    constexpr int most_steps = 100;
    DifferencePoint p3 = p2;
    const auto is_beside = [&](const DifferencePoint& p, const DifferencePoint& q) {
        return p.difference.cross(q.difference).dot(inner) < 0;
    };
    int step = 0;
    for (;; ++step) {
        if (step == most_steps || out.isZero(0)) return std::nullopt;
        p3 = body.support(out);
        if (is_beside(p1, p3)) {
            p2 = p3;
        } else if (is_beside(p3, p2)) {
            p1 = p3;
        } else {
            break;
        }
        out = (p1.difference - inner).cross(p2.difference - inner);
    }
    for (; step < most_steps; ++step) {
        out = unit_of((p2.difference - p1.difference).cross(p3.difference - p1.difference));
        const double least =
            std::min({out.dot(p1.difference), out.dot(p2.difference), out.dot(p3.difference)});
        if (least > rounding) return std::array{p1, p2, p3};
        const DifferencePoint next = body.support(out);
        if (!(out.dot(next.difference) > rounding)) return std::nullopt;
        const Vec3 across = next.difference.cross(inner);
        if (p1.difference.dot(across) > 0) {
            (p2.difference.dot(across) > 0 ? p1 : p3) = next;
        } else {
            (p3.difference.dot(across) > 0 ? p2 : p1) = next;
        }
    }
    return std::nullopt;
}

// A surface of triangles about the origin that grows towards the body's: expanding polytope [bergen-2001].
//
// That the least distance of its facets from the origin is a lower bound of the depth needs neither convexity
// nor right normals. (1) Every edge has an even number of facets: so it is at first, and what replaces facets
// is the cone over those edges of them that come an odd number of times. (2) Rays from the origin
// cross it an odd number of times: so do those of the first tetrahedron, which holds a point nearer to the origin
// than any facet is, and a facet is replaced only if all corners of it and the new point are beyond one plane that the origin is not, so that
// no tetrahedron of the two holds the origin. (3) So every ray ends on a facet, at a point of it, all of
// which are at least n . corner away, for any unit vector n. The ball of the least of these is
// within the corners' hull. Corners are points of A - B, once the inner point is none of them any more.
class GrowingPolytope {
public:
    GrowingPolytope(const DifferencePoint& inner, const std::array<DifferencePoint, 3>& portal,
                    double rounding)
        : rounding_(rounding)
    {
        points_.push_back(inner.difference);
        for (const DifferencePoint& p : portal) points_.push_back(p.difference);
        constexpr std::array<std::array<std::uint32_t, 3>, 4> sides = {
            {{1, 2, 3}, {0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
        for (const auto& side : sides) add(side);
    }

    /// False once a facet is so thin or so near the origin that doubles say nothing about it.
    [[nodiscard]] bool is_valid() const { return is_valid_; }
    [[nodiscard]] std::size_t size() const { return points_.size(); }

    struct Facet {
        std::array<std::uint32_t, 3> corners; ///< the inner point first, where it is one
        Vec3 normal;                          ///< of length 1, away from the origin
        double least;                         ///< of normal . corner
        double most;

        [[nodiscard]] bool has_inner_point() const { return corners[0] == 0; }
    };

    /// The facet to be grown next: one with the inner point, or the nearest. \pre is_valid()
    [[nodiscard]] const Facet& next() const
    {
        return *std::ranges::min_element(facets_, {}, [](const Facet& facet) {
            return std::pair(!facet.has_inner_point(), facet.least);
        });
    }

    /// False where no facet sees the point.
    bool grow(const Vec3& point)
    {
        sides_.clear();
        const auto sees = [&](const Facet& facet) {
            if (!(facet.normal.dot(point) > facet.most)) return false;
            const auto& c = facet.corners;
            for (const auto& [p, q] : {std::pair(c[0], c[1]), {c[1], c[2]}, {c[2], c[0]}})
                sides_.push_back(std::minmax({p, q}));
            return true;
        };
        const auto seen = std::remove_if(facets_.begin(), facets_.end(), sees);
        if (seen == facets_.end()) return false;
        facets_.erase(seen, facets_.end());
        std::ranges::sort(sides_);
        const auto number = static_cast<std::uint32_t>(points_.size());
        points_.push_back(point);
        for (std::size_t i = 0; i < sides_.size();) {
            std::size_t end = i;
            while (end < sides_.size() && sides_[end] == sides_[i]) ++end;
            if ((end - i) % 2 != 0) add({sides_[i].first, sides_[i].second, number});
            i = end;
        }
        return true;
    }

private:
    void add(const std::array<std::uint32_t, 3>& corners)
    {
        const Vec3& p = points_[corners[0]];
        const Vec3& q = points_[corners[1]];
        const Vec3& r = points_[corners[2]];
        Vec3 normal = unit_of((q - p).cross(r - p));
        if (normal.dot(p) < 0) normal = -normal;
        const auto [least, most] = std::minmax({normal.dot(p), normal.dot(q), normal.dot(r)});
        if (!(least > rounding_)) is_valid_ = false;
        facets_.push_back({corners, normal, least, most});
    }

    double rounding_;
    bool is_valid_ = true;
    std::vector<Vec3> points_; ///< the inner one first
    std::vector<Facet> facets_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides_; ///< of facets that see a point
};

/// The point of A where four differences, weighted, make up the origin. Nothing where it is not shown to be in
/// their tetrahedron.
std::optional<Vec3> common_point(const DifferencePoint& inner,
                                 const std::array<DifferencePoint, 3>& portal, double rounding)
{
    Mat3 sides;
    Mat3 of_a;
    for (int i = 0; i < 3; ++i) {
        const DifferencePoint& p = portal[static_cast<std::size_t>(i)];
        sides.col(i) = p.difference - inner.difference;
        of_a.col(i) = p.of_a - inner.of_a;
    }
    const Vec3 weights = sides.fullPivLu().solve(-inner.difference);
    const Vec3 origin = inner.difference + sides * weights;
    if (!(weights.minCoeff() >= 0 && weights.sum() <= 1 && length_of(origin) <= 0.5 * rounding))
        return std::nullopt;
    return inner.of_a + of_a * weights;
}

} // namespace

std::optional<HullDepth> find_hull_depth(const ConvexPolyhedron& a, const ConvexPolyhedron& b,
                                         std::span<const Vec3> moved_b, double rounding)
{
    DifferenceBody body(a, b, moved_b);
    const auto portal = find_portal(body, rounding);
    if (!portal) return std::nullopt;
    const auto common = common_point(body.inner(), *portal, rounding);
    if (!common) return std::nullopt;
    GrowingPolytope polytope(body.inner(), *portal, rounding);
    constexpr std::size_t most_points = 1000;
    HullDepth best = {.common = *common};
    double upper = HUGE_VAL;
    while (polytope.is_valid() && polytope.size() < most_points) {
        const GrowingPolytope::Facet nearest = polytope.next();
        const Vec3 farthest = body.support(nearest.normal).difference;
        const double reach = nearest.normal.dot(farthest);
        if (reach < upper) {
            upper = reach;
            best.direction = nearest.normal;
        }
        if (!nearest.has_inner_point() && upper - nearest.least <= 2 * rounding) {
            best.lower = nearest.least;
            return best;
        }
        if (!polytope.grow(farthest)) break;
    }
    return std::nullopt;
}

} // namespace proxima
