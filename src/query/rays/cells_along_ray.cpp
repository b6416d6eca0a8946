#include "proxima/cells_along_ray.h"

#include "base/fixed_stack.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// A position on the ray: where it crosses a plane of an axis, or a t that is given.
struct Event {
    static constexpr int given = 3;

    double t = 0;        ///< rounded, put in order
    double position = 0; ///< of the plane
    int axis = given;
};

/// A cell that the ray is yet to go through.
struct PendingCell {
    Cell cell;
    Event enter;
    Event exit;
};

class Walk {
public:
    Walk(const Octree& octree, const Ray& ray) noexcept
        : octree_(octree), ray_(ray), length_(length_of(ray.direction))
    {}

    void run(FunctionRef<Flow(const CellOnRay&)> visitor) noexcept
    {
        PendingCell root;
        if (!enter_root(root)) return;
        // A split cell makes way for at most four of its children.
        FixedStack<PendingCell, 3 * max_octree_depth + 1> pending;
        pending.push(root);
        while (!pending.empty()) {
            const PendingCell at = pending.pop();
            if (octree_.is_leaf(at.cell)) {
                if (visitor(describe(at)) == Flow::stop) return;
                continue;
            }
            std::array<PendingCell, 4> children;
            for (int i = split(at, children); i-- > 0;)
                pending.push(children[static_cast<std::size_t>(i)]);
        }
    }

private:
    /// The sign of t(a) - t(b), exactly.
    [[nodiscard]] int compare(const Event& a, const Event& b) const noexcept
    {
        // Planes' t have two roundings, and at most a few more where they were put in order.
        constexpr double unsure = 0x1p-48;
        constexpr double safe = 0x1p-900;
        const double gap = a.t - b.t;
        const double size = std::max(std::abs(a.t), std::abs(b.t));
        if (std::abs(gap) > unsure * size && size > safe) return gap > 0 ? 1 : -1;
        if (a.t == b.t && std::isinf(a.t)) return 0;
        if (a.axis == Event::given && b.axis == Event::given)
            return static_cast<int>(a.t > b.t) - static_cast<int>(a.t < b.t);
        if (a.axis == Event::given) return -compare_with_given(b, a.t);
        if (b.axis == Event::given) return compare_with_given(a, b.t);
        if (a.axis == b.axis) {
            const int sign = static_cast<int>(a.position > b.position) -
                             static_cast<int>(a.position < b.position);
            return ray_.direction[a.axis] > 0 ? sign : -sign;
        }
        // (a - o_i) / d_i against (b - o_j) / d_j, times d_i d_j.
        Displacement reach{ray_.origin, ray_.origin};
        reach.to[a.axis] = a.position;
        reach.to[b.axis] = b.position;
        const int third = 3 - a.axis - b.axis;
        int sign = cross_component_sign(reach, Displacement{Vec3::Zero(), ray_.direction}, third);
        if ((third + 1) % 3 != a.axis) sign = -sign;
        return (ray_.direction[a.axis] > 0) == (ray_.direction[b.axis] > 0) ? sign : -sign;
    }

    /// The sign of t(plane) - t, exactly.
    [[nodiscard]] int compare_with_given(const Event& plane, double t) const noexcept
    {
        if (std::isinf(t)) return t > 0 ? -1 : 1;
        // Component of e_j x w along the third axis is w_i, or -w_i: w = position - o - t d.
        const int i = plane.axis;
        const int j = (i + 2) % 3;
        Vec3 point = Vec3::Zero();
        point[i] = plane.position;
        const SumDisplacement w{point, ray_.origin, ray_.direction, t};
        const int sign =
            cross_component_sign(Displacement{Vec3::Zero(), Vec3::Unit(j)}, w, (i + 1) % 3);
        return ray_.direction[i] > 0 ? sign : -sign;
    }

    [[nodiscard]] Event crossing(int axis, double position) const noexcept
    {
        return {(position - ray_.origin[axis]) / ray_.direction[axis], position, axis};
    }

    /// False where the ray has no stretch in the root.
    [[nodiscard]] bool enter_root(PendingCell& root) const noexcept
    {
        const Box box = octree_.box(octree_.root());
        Event enter{ray_.t_min, 0, Event::given};
        Event exit{ray_.t_max, 0, Event::given};
        for (int axis = 0; axis < 3; ++axis) {
            const double d = ray_.direction[axis];
            if (d == 0) {
                const double o = ray_.origin[axis];
                if (o < box.lower[axis] || o > box.upper[axis]) return false;
                continue;
            }
            const Event near = crossing(axis, d > 0 ? box.lower[axis] : box.upper[axis]);
            const Event far = crossing(axis, d > 0 ? box.upper[axis] : box.lower[axis]);
            if (compare(near, enter) > 0) enter = near;
            if (compare(far, exit) < 0) exit = far;
        }
        if (compare(enter, exit) >= 0) return false;
        exit.t = std::max(enter.t, exit.t);
        root = {octree_.root(), enter, exit};
        return true;
    }

    /// The children in order; returns how many.
    [[nodiscard]] int split(const PendingCell& at,
                            std::array<PendingCell, 4>& children) const noexcept
    {
        const auto coordinates = cell_coordinates(at.cell.key);
        const int level = depth(at.cell.key) + 1;
        int octant = 0;
        std::array<Event, 3> inside; // crossings of middle planes between enter and exit, in order
        int count = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const std::uint32_t index = 2 * coordinates[static_cast<std::size_t>(axis)] + 1;
            const double middle = octree_.frame().plane(axis, index, level);
            const double d = ray_.direction[axis];
            if (d == 0) {
                if (ray_.origin[axis] >= middle) octant |= 1 << axis;
                continue;
            }
            Event event = crossing(axis, middle);
            const bool crossed = compare(event, at.enter) <= 0;
            if (crossed == (d > 0)) octant |= 1 << axis;
            if (crossed || compare(event, at.exit) >= 0) continue;
            int slot = count++;
            for (; slot > 0 && compare(event, inside[static_cast<std::size_t>(slot - 1)]) < 0;
                 --slot) {
                inside[static_cast<std::size_t>(slot)] = inside[static_cast<std::size_t>(slot - 1)];
            }
            inside[static_cast<std::size_t>(slot)] = event;
        }
        int made = 0;
        Event enter = at.enter;
        for (int i = 0; i < count;) {
            Event exit = inside[static_cast<std::size_t>(i)];
            exit.t = std::clamp(exit.t, enter.t, at.exit.t);
            children[static_cast<std::size_t>(made++)] = {octree_.child(at.cell, octant), enter,
                                                          exit};
            const Event& group = inside[static_cast<std::size_t>(i)];
            int next = i;
            for (; next < count && compare(inside[static_cast<std::size_t>(next)], group) == 0;
                 ++next)
                octant ^= 1 << inside[static_cast<std::size_t>(next)].axis;
            enter = exit;
            i = next;
        }
        children[static_cast<std::size_t>(made++)] = {octree_.child(at.cell, octant), enter,
                                                      at.exit};
        return made;
    }

    [[nodiscard]] CellOnRay describe(const PendingCell& at) const noexcept
    {
        return {at.cell, at.enter.t, at.exit.t, (at.exit.t - at.enter.t) * length_,
                penetration(octree_.box(at.cell), ray_)};
    }

    const Octree& octree_;
    const Ray& ray_;
    double length_;
};

} // namespace

void cells_along_ray(const Octree& octree, const Ray& ray,
                     FunctionRef<Flow(const CellOnRay&)> visitor) noexcept
{
    if (octree.nodes().empty() || !is_valid(ray)) return;
    Walk(octree, ray).run(visitor);
}

std::vector<CellOnRay> cells_along_ray(const Octree& octree, const Ray& ray)
{
    std::vector<CellOnRay> cells;
    cells_along_ray(octree, ray, [&](const CellOnRay& cell) {
        cells.push_back(cell);
        return Flow::proceed;
    });
    return cells;
}

double penetration(const Box& box, const Ray& ray) noexcept
{
    const Vec3 d = ray.direction / ray.direction.cwiseAbs().maxCoeff();
    const Vec3 half = 0.5 * box.extent();
    const Vec3 away = box.center() - ray.origin;
    double depth = std::numeric_limits<double>::infinity();
    double most = depth;
    for (int k = 0; k < 3; ++k) {
        const Vec3 normal = Vec3::Unit(k).cross(d);
        const double length = normal.norm();
        if (!(length > 0)) continue;
        const double reach = normal.cwiseAbs().dot(half);
        depth = std::min(depth, (reach - std::abs(normal.dot(away))) / length);
        most = std::min(most, reach / length);
    }
    return most > 0 ? std::clamp(depth / most, 0.0, 1.0) : 0.0;
}

} // namespace proxima
