#include "thesis/minkowski_sums/incremental_hull.h"

#include "minkowski/operation_counts.h"
#include "minkowski/scalar_vector.h"
#include "thesis/minkowski_sums/geometric_method.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace proxima {
namespace {

/// A face's side, in the direction of the face.
struct DirectedEdge {
    int from = 0;
    int to = 0;
};

template <class Scalar>
class HullBuilder {
public:
    explicit HullBuilder(std::span<const Vector3<Scalar>> points) : points_(points)
    {
        for (const Vector3<Scalar>& point : points)
            reach_ = reach_.cwiseMax(plain(point).cwiseAbs());
    }

    std::optional<std::vector<HullFace<Scalar>>> build()
    {
        const auto corners = find_tetrahedron();
        if (!corners) return std::nullopt;
        start(*corners);
        for (int p = 0; p < static_cast<int>(points_.size()); ++p) {
            if (std::ranges::find(*corners, p) == corners->end() && !add(p)) return std::nullopt;
        }
        return std::move(faces_);
    }

private:
    [[nodiscard]] static Vec3 plain(const Vector3<Scalar>& v)
    {
        return {to_double(v.x()), to_double(v.y()), to_double(v.z())};
    }
    [[nodiscard]] const Vector3<Scalar>& point(int index) const
    {
        return points_[static_cast<std::size_t>(index)];
    }

    /// How far rounding may put a point of the plane of ab and ac off it.
    [[nodiscard]] double tolerance(const Vector3<Scalar>& ab, const Vector3<Scalar>& ac) const
    {
        return 32 * unit_roundoff * cross_magnitude(plain(ab), plain(ac)).dot(reach_);
    }

    [[nodiscard]] HullFace<Scalar> make_face(int a, int b, int c) const
    {
        const Vector3<Scalar> ab = point(b) - point(a);
        const Vector3<Scalar> ac = point(c) - point(a);
        HullFace<Scalar> face;
        face.vertices = {a, b, c};
        face.normal = cross(ab, ac);
        face.offset = dot(face.normal, point(a));
        face.visible_above = Scalar(to_double(face.offset) + tolerance(ab, ac));
        return face;
    }

    /// The index in [0, points) of the largest measure, if that is above the tolerance.
    template <class Measure>
    [[nodiscard]] std::optional<int> farthest(Measure measure, double tolerance) const
    {
        int best = 0;
        Scalar largest = measure(0);
        for (int p = 1; p < static_cast<int>(points_.size()); ++p) {
            const Scalar value = measure(p);
            if (value > largest) {
                largest = value;
                best = p;
            }
        }
        if (!(largest > Scalar(tolerance))) return std::nullopt;
        return best;
    }

    /// Step 1: a point, the one farthest from it, from their line, from their plane.
    [[nodiscard]] std::optional<std::array<int, 4>> find_tetrahedron() const
    {
        if (points_.size() < 4) return std::nullopt;
        const Vector3<Scalar>& origin = point(0);
        const auto squared = [](const Vector3<Scalar>& v) { return dot(v, v); };
        const auto p1 =
            farthest([&](int p) { return squared(Vector3<Scalar>(point(p) - origin)); }, 0);
        if (!p1) return std::nullopt;
        const Vector3<Scalar> line = point(*p1) - origin;
        const auto p2 = farthest(
            [&](int p) { return squared(cross(line, Vector3<Scalar>(point(p) - origin))); }, 0);
        if (!p2) return std::nullopt;
        const HullFace<Scalar> base = make_face(0, *p1, *p2);
        const auto p3 = farthest(
            [&](int p) {
                const Scalar height = dot(base.normal, point(p)) - base.offset;
                return height > Scalar(0) ? height : -height;
            },
            to_double(base.visible_above) - to_double(base.offset));
        if (!p3) return std::nullopt;
        return std::array<int, 4>{0, *p1, *p2, *p3};
    }

    void start(const std::array<int, 4>& corners)
    {
        auto [a, b, c, d] = corners;
        const HullFace<Scalar> base = make_face(a, b, c);
        if (dot(base.normal, point(d)) > base.offset) std::swap(b, c);
        faces_ = {make_face(a, b, c), make_face(a, d, b), make_face(b, d, c), make_face(c, d, a)};
    }

    /// Steps 2 to 6 for one point. False when the outline is not one closed loop.
    [[nodiscard]] bool add(int p)
    {
        std::vector<DirectedEdge> sides;
        const auto is_visible = [&](const HullFace<Scalar>& face) {
            return dot(face.normal, point(p)) > face.visible_above;
        };
        std::erase_if(faces_, [&](const HullFace<Scalar>& face) {
            if (!is_visible(face)) return false;
            const auto& v = face.vertices;
            sides.insert(sides.end(), {{v[0], v[1]}, {v[1], v[2]}, {v[2], v[0]}});
            return true;
        });
        if (sides.empty()) return true;

        std::vector<DirectedEdge> outline;
        for (const DirectedEdge& side : sides) {
            const auto is_opposite = [&](const DirectedEdge& other) {
                return other.from == side.to && other.to == side.from;
            };
            if (std::ranges::none_of(sides, is_opposite)) outline.push_back(side);
        }
        if (!is_one_loop(outline)) return false;
        for (const DirectedEdge& side : outline) {
            faces_.push_back(make_face(side.from, side.to, p));
        }
        return true;
    }

    [[nodiscard]] static bool is_one_loop(const std::vector<DirectedEdge>& outline)
    {
        if (outline.size() < 3) return false;
        int at = outline.front().from;
        for (std::size_t step = 0; step < outline.size(); ++step) {
            const auto leaves = [&](const DirectedEdge& side) { return side.from == at; };
            if (std::ranges::count_if(outline, leaves) != 1) return false;
            at = std::ranges::find_if(outline, leaves)->to;
            const bool closed = at == outline.front().from;
            if (closed != (step + 1 == outline.size())) return false;
        }
        return true;
    }

    std::span<const Vector3<Scalar>> points_;
    Vec3 reach_ = Vec3::Zero();
    std::vector<HullFace<Scalar>> faces_;
};

} // namespace

template <class Scalar>
std::optional<std::vector<HullFace<Scalar>>>
incremental_hull(std::span<const Vector3<Scalar>> points)
{
    return HullBuilder<Scalar>(points).build();
}

template std::optional<std::vector<HullFace<double>>>
    incremental_hull(std::span<const Vector3<double>>);
template std::optional<std::vector<HullFace<Counted>>>
    incremental_hull(std::span<const Vector3<Counted>>);

} // namespace proxima
