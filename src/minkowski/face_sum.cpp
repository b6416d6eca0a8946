#include "minkowski/face_sum.h"

#include "base/check.h"
#include "geometry/exact_predicates.h"

#include <optional>
#include <utility>

namespace proxima::detail {
namespace {

/// Turns in the plane of the faces, counter-clockwise about the normal, seen along an axis.
class FacePlane {
public:
    explicit FacePlane(const ConvexPolyhedron::NormalFactors& normal)
    {
        int sign = 0;
        for (axis_ = 0; axis_ < 3; ++axis_) {
            sign = cross_component_sign(normal.u, normal.v, axis_);
            if (sign != 0) break;
        }
        right_ = (axis_ + 1) % 3;
        up_ = (axis_ + 2) % 3;
        if (sign < 0) std::swap(right_, up_);
        sign_ = sign;
    }

    /// +1 if v is to the left of u.
    [[nodiscard]] int turn(const Displacement& u, const Displacement& v) const noexcept
    {
        return sign_ * cross_component_sign(u, v, axis_);
    }

    [[nodiscard]] Displacement right() const noexcept { return {Vec3::Zero(), Vec3::Unit(right_)}; }

    /// Whether p lies lower, or as low and more to the left.
    [[nodiscard]] bool is_before(const Vec3& p, const Vec3& q) const noexcept
    {
        return p[up_] < q[up_] || (p[up_] == q[up_] && p[right_] < q[right_]);
    }

private:
    int axis_ = 0;
    int right_ = 0;
    int up_ = 0;
    int sign_ = 0;
};

/// Compares directions by their angle from a first one, in [0, 360) degrees.
class AngleOrder {
public:
    AngleOrder(const FacePlane& plane, Displacement first) : plane_(plane), first_(std::move(first))
    {}

    /// -1, 0, +1 as u comes before, with, or after v.
    [[nodiscard]] int compare(const Displacement& u, const Displacement& v) const noexcept
    {
        const int half_u = half(u);
        const int half_v = half(v);
        return half_u != half_v ? half_u - half_v : -plane_.turn(u, v);
    }

private:
    [[nodiscard]] int half(const Displacement& u) const noexcept
    {
        const int turn = plane_.turn(first_, u);
        if (turn != 0) return turn > 0 ? 0 : 1;
        return point_same_way(first_, u) ? 0 : 1;
    }

    const FacePlane& plane_;
    Displacement first_;
};

/// A face as the chain of edges that its boundary is, counter-clockwise.
class Chain {
public:
    explicit Chain(const FaceView& face) : polyhedron_(*face.polyhedron), vertices_(face.vertices)
    {
        // Points first, then the ray that leaves and the one that comes in.
        const std::size_t size = vertices_.size();
        const bool unbounded = has_ray();
        while (is_ray(first_) || (unbounded && !is_ray(before(first_)))) ++first_;
        while (point_count_ < size && !is_ray(first_ + point_count_)) ++point_count_;
        PROXIMA_CHECK_LT(0U, point_count_);
    }

    [[nodiscard]] bool is_bounded() const noexcept { return point_count_ == vertices_.size(); }
    [[nodiscard]] std::uint32_t point(std::size_t i) const noexcept
    {
        return vertices_[(first_ + i % point_count_) % vertices_.size()];
    }
    [[nodiscard]] const Vec3& position(std::size_t i) const noexcept
    {
        return polyhedron_.vertex(point(i));
    }
    [[nodiscard]] std::uint32_t leaving_ray() const noexcept
    {
        return vertices_[(first_ + point_count_) % vertices_.size()];
    }
    [[nodiscard]] std::uint32_t coming_ray() const noexcept { return vertices_[before(first_)]; }
    [[nodiscard]] Displacement ray(std::uint32_t vertex) const noexcept
    {
        return {Vec3::Zero(), polyhedron_.vertex(vertex)};
    }

    /// Moves to the point at which the turn that begins with a direction starts.
    void start_at(const FacePlane& plane, const Displacement& first) noexcept
    {
        at_ = 0;
        for (std::size_t i = 1; i < point_count_; ++i) {
            const Displacement d = {position(at_), position(i)};
            const int turn = plane.turn(first, d);
            if (turn < 0 || (turn == 0 && point_same_way(first, d))) at_ = i;
        }
        steps_left_ = edge_count(at_);
    }

    /// Moves to the start of a full turn that begins to the right.
    void start_lowest(const FacePlane& plane) noexcept
    {
        at_ = 0;
        for (std::size_t i = 1; i < point_count_; ++i) {
            if (plane.is_before(position(i), position(at_))) at_ = i;
        }
        steps_left_ = edge_count(at_);
    }

    [[nodiscard]] std::uint32_t at() const noexcept { return point(at_); }
    [[nodiscard]] std::optional<Displacement> next_edge() const noexcept
    {
        if (steps_left_ == 0) return std::nullopt;
        return Displacement{position(at_), position(at_ + 1)};
    }
    void step() noexcept
    {
        ++at_;
        --steps_left_;
    }

private:
    [[nodiscard]] bool is_ray(std::size_t i) const noexcept
    {
        return polyhedron_.is_ray(vertices_[i % vertices_.size()]);
    }
    [[nodiscard]] std::size_t before(std::size_t i) const noexcept
    {
        return (i + vertices_.size() - 1) % vertices_.size();
    }
    [[nodiscard]] bool has_ray() const noexcept
    {
        for (std::size_t i = 0; i < vertices_.size(); ++i) {
            if (is_ray(i)) return true;
        }
        return false;
    }
    [[nodiscard]] std::size_t edge_count(std::size_t from) const noexcept
    {
        if (!is_bounded()) return point_count_ - 1 - from;
        return point_count_ > 1 ? point_count_ : 0;
    }

    const ConvexPolyhedron& polyhedron_;
    std::span<const std::uint32_t> vertices_;
    std::size_t first_ = 0;
    std::size_t point_count_ = 0;
    std::size_t at_ = 0;
    std::size_t steps_left_ = 0;
};

/// The rays between which an unbounded sum opens.
struct Opening {
    SumCorner leaving;
    SumCorner coming;
    Displacement leaving_direction;
    Displacement coming_direction;
};

std::optional<Opening> find_opening(const FacePlane& plane, const Chain& a, const Chain& b)
{
    using Kind = SumCorner::Kind;
    if (a.is_bounded() && b.is_bounded()) return std::nullopt;
    const auto opening_of = [](const Chain& chain, Kind kind) {
        const auto corner = [&](std::uint32_t ray) {
            return kind == Kind::ray_of_a ? SumCorner{kind, ray, 0} : SumCorner{kind, 0, ray};
        };
        const std::uint32_t leaving = chain.leaving_ray();
        const std::uint32_t coming = chain.coming_ray();
        return Opening{corner(leaving), corner(coming), chain.ray(leaving), chain.ray(coming)};
    };
    if (b.is_bounded()) return opening_of(a, Kind::ray_of_a);
    Opening result = opening_of(b, Kind::ray_of_b);
    if (a.is_bounded()) return result;
    // The recession cone goes counter-clockwise from the leaving to the coming ray: the widest.
    const Opening of_a = opening_of(a, Kind::ray_of_a);
    if (plane.turn(of_a.leaving_direction, result.leaving_direction) >= 0) {
        result.leaving = of_a.leaving;
        result.leaving_direction = of_a.leaving_direction;
    }
    if (plane.turn(result.coming_direction, of_a.coming_direction) >= 0) {
        result.coming = of_a.coming;
        result.coming_direction = of_a.coming_direction;
    }
    return result;
}

} // namespace

bool append_face_sum(const FaceView& face_a, const FaceView& face_b,
                     const ConvexPolyhedron::NormalFactors& normal, std::vector<SumCorner>& corners)
{
    const FacePlane plane(normal);
    Chain a(face_a);
    Chain b(face_b);
    const std::optional<Opening> opening = find_opening(plane, a, b);
    Displacement first = plane.right();
    if (opening) {
        first = {opening->coming_direction.to, Vec3::Zero()};
        a.start_at(plane, first);
        b.start_at(plane, first);
    } else {
        a.start_lowest(plane);
        b.start_lowest(plane);
    }
    const AngleOrder order(plane, first);
    const auto usable = [&](std::optional<Displacement> edge) {
        const bool beyond =
            edge && opening && order.compare(*edge, opening->leaving_direction) >= 0;
        return beyond ? std::nullopt : edge;
    };

    const std::size_t begin = corners.size();
    while (true) {
        const auto next_a = usable(a.next_edge());
        const auto next_b = usable(b.next_edge());
        if (opening || next_a || next_b)
            corners.push_back({SumCorner::Kind::point, a.at(), b.at()});
        if (!next_a && !next_b) break;
        int first_edge = next_a ? -1 : 1;
        if (next_a && next_b) first_edge = order.compare(*next_a, *next_b);
        if (first_edge <= 0) a.step();
        if (first_edge >= 0) b.step();
    }
    bool is_strip = false;
    if (opening) {
        corners.push_back(opening->leaving);
        is_strip = plane.turn(opening->leaving_direction, opening->coming_direction) == 0;
        if (!is_strip) corners.push_back(opening->coming);
    }
    return corners.size() - begin >= 3;
}

} // namespace proxima::detail
