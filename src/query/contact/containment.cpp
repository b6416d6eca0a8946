#include "proxima/intersect_meshes.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "geometry/exact_predicates.h"
#include "index/index_parts.h"
#include "index/signs/sign_parts.h"
#include "mesh/coincidence.h"
#include "query/contact/enclosure_parts.h"
#include "query/contact/visit_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace proxima {

// The steps of build_enclosure.
class EnclosureBuilder {
public:
    EnclosureBuilder(const MeshIndex& index, const TriangleMesh& mesh,
                     const EnclosureOptions& options)
        : result_(std::make_shared<EnclosureParts>()), mesh_(mesh), options_(options)
    {
        result_->index = index;
    }

    Result<Enclosure> build()
    {
        const auto bounds = checked_bounding_box(mesh_);
        if (!bounds) return tl::unexpected(bounds.error());
        result_->bounds = *bounds;
        same_position_ = detail::first_at_position(mesh_);
        result_->vertices = find_vertices();
        if (is_cancelled(options_.execution.progress)) return stopped();
        result_->method = find_method();
        if (is_cancelled(options_.execution.progress)) return stopped();
        if (result_->method == InsideMethod::winding_number) {
            if (Status status = find_winding(); !status) return tl::unexpected(status.error());
        }
        return Enclosure(std::move(result_));
    }

private:
    static tl::unexpected<Error> stopped() { return cancelled("preparing for containment"); }

    [[nodiscard]] std::vector<Vec3> find_vertices() const
    {
        DisjointSets sets(mesh_.vertex_count());
        std::vector<bool> used(mesh_.vertex_count());
        for (const TriangleCorners& corners : mesh_.triangles()) {
            for (const std::uint32_t corner : corners) {
                sets.unite(same_position_[corners[0]], same_position_[corner]);
                used[same_position_[corner]] = true;
            }
        }
        std::vector<Vec3> lowest;
        for (std::uint32_t id = 0; id < mesh_.vertex_count(); ++id) {
            if (used[id] && sets.find(id) == id) lowest.push_back(mesh_.position(VertexId{id}));
        }
        return lowest;
    }

    /// By the edges of all triangles: each direction as often as the other one, or an even number
    /// in all.
    [[nodiscard]] InsideMethod find_method() const
    {
        struct Edge {
            std::uint64_t vertices;
            int direction;
        };
        std::vector<Edge> edges;
        edges.reserve(3 * mesh_.triangle_count());
        for (const TriangleCorners& corners : mesh_.triangles()) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint64_t from = same_position_[corners[i]];
                const std::uint64_t to = same_position_[corners[(i + 1) % 3]];
                if (from == to) continue;
                const auto [low, high] = std::minmax(from, to);
                edges.push_back({low << 32U | high, from < to ? 1 : -1});
            }
        }
        std::ranges::sort(edges, {}, &Edge::vertices);
        bool oriented = true;
        for (std::size_t i = 0; i < edges.size();) {
            const std::size_t first = i;
            int sum = 0;
            for (; i < edges.size() && edges[i].vertices == edges[first].vertices; ++i)
                sum += edges[i].direction;
            if ((i - first) % 2 != 0) return InsideMethod::winding_number;
            oriented = oriented && sum == 0;
        }
        return oriented ? InsideMethod::crossings : InsideMethod::parity;
    }

    /// The signs' winding number, or one of its own.
    Status find_winding()
    {
        const IndexParts& parts = result_->index.parts();
        if (parts.signs() != nullptr) {
            result_->winding = parts.signs()->arrays().winding;
            return {};
        }
        auto winding = build_winding_number(mesh_, {.execution = options_.execution});
        if (!winding) return tl::unexpected(winding.error());
        std::vector<std::uint32_t> rows(parts.triangle_count());
        for (std::uint32_t row = 0; row < rows.size(); ++row) rows[to_index(parts.id(row))] = row;
        result_->own_winding = std::move(*winding).release();
        for (std::uint32_t& number : result_->own_winding.order) number = rows[number];
        result_->winding = result_->own_winding.view();
        return {};
    }

    std::shared_ptr<EnclosureParts> result_;
    const TriangleMesh& mesh_;
    const EnclosureOptions& options_;
    std::vector<std::uint32_t> same_position_;
};

namespace {

/// On which side of the line from a to b the point is, seen along x, after a shift to larger y and
/// a much smaller one to larger z: never on it, unless a and b are one.
int side_of_shifted(const Vec3& a, const Vec3& b, const Vec3& point) noexcept
{
    const int side = orient2d({a.y(), a.z()}, {b.y(), b.z()}, {point.y(), point.z()});
    if (side != 0) return side;
    if (a.z() != b.z()) return a.z() > b.z() ? 1 : -1;
    return a.y() == b.y() ? 0 : a.y() < b.y() ? 1 : -1;
}

/// How the ray along x from the shifted point crosses the triangle: +1 outwards, -1 inwards, or not
/// at all. An edge that two triangles share is crossed in one of them.
int crossing_ahead(const Triangle& t, const Vec3& point) noexcept
{
    for (const int axis : {1, 2}) {
        const auto [low, high] = std::minmax({t[0][axis], t[1][axis], t[2][axis]});
        if (point[axis] < low || point[axis] > high) return 0;
    }
    const int turn = side_of_shifted(t[0], t[1], point);
    if (turn == 0 || side_of_shifted(t[1], t[2], point) != turn ||
        side_of_shifted(t[2], t[0], point) != turn)
        return 0;
    return orient3d(t[0], t[1], t[2], point) * turn < 0 ? turn : 0;
}

/// Whether the box moved by the pose surely does not hold the point.
bool surely_outside(const Box& box, const RigidTransform& pose, const Vec3& point) noexcept
{
    const Vec3 there = pose.inverse()(point);
    // The pose may stretch by rigid_tolerance; rounding is less.
    const double size = point.cwiseAbs().maxCoeff() + pose.translation.cwiseAbs().maxCoeff() +
                        box.lower.cwiseAbs().maxCoeff() + box.upper.cwiseAbs().maxCoeff();
    const double slack = 8 * rigid_tolerance * size;
    return (there.array() < box.lower.array() - slack).any() ||
           (there.array() > box.upper.array() + slack).any();
}

/// The boxes of an index, moved by a pose and seen from a point: which of them the ray from there
/// along x may meet.
class RayAlongX {
public:
    RayAlongX(const IndexParts& index, const Box& bounds, const RigidTransform& pose,
              const Vec3& point) noexcept
        : turn_(pose.rotation * index.unscale()), from_point_(pose(index.center()) - point)
    {
        // The center, corners as the pose rounds them, and what is computed here: each is a sum of
        // a few products no larger than this, and off by less than eight roundings of it. Boxes
        // hold the mesh's own corners, except in meshes beyond the largest scale of a frame.
        const double size =
            3 * std::max(bounds.lower.cwiseAbs().maxCoeff(), bounds.upper.cwiseAbs().maxCoeff()) *
                pose.rotation.cwiseAbs().maxCoeff() +
            pose.translation.cwiseAbs().maxCoeff() + point.cwiseAbs().maxCoeff();
        slack_ = size < 0x1p999 ? 0x1p-44 * size + 8 * std::numeric_limits<double>::min()
                                : std::numeric_limits<double>::infinity();
    }

    /// In the index's frame. True where a number is not finite.
    [[nodiscard]] bool may_meet(const Vec3& lower, const Vec3& upper) const noexcept
    {
        const Vec3 middle = turn_ * (0.5 * (lower + upper)) + from_point_;
        const Vec3 reach = turn_.cwiseAbs() * (0.5 * (upper - lower));
        const auto beyond = [&](int axis) { return std::abs(middle[axis]) > reach[axis] + slack_; };
        return !(beyond(1) || beyond(2) || middle.x() + reach.x() < -slack_);
    }

private:
    Mat3 turn_;
    Vec3 from_point_;
    double slack_;
};

bool contains_all(const Enclosure& outer, const RigidTransform& outer_pose, const Enclosure& inner,
                  const RigidTransform& inner_pose) noexcept
{
    const EnclosureParts& parts = inner.parts();
    return std::ranges::all_of(parts.vertices, [&](const Vec3& vertex) {
        return encloses(outer, outer_pose, inner_pose(vertex));
    });
}

} // namespace

Enclosure::Enclosure(std::shared_ptr<const EnclosureParts> parts) noexcept
    : parts_(std::move(parts))
{}

InsideMethod Enclosure::method() const noexcept
{
    return parts_->method;
}

Result<Enclosure> build_enclosure(const MeshIndex& index, const EnclosureOptions& options)
{
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    return EnclosureBuilder(index, *mesh, options).build();
}

bool encloses(const Enclosure& enclosure, const RigidTransform& pose, const Vec3& point) noexcept
{
    const EnclosureParts& parts = enclosure.parts();
    const IndexParts& index = parts.index.parts();
    if (surely_outside(parts.bounds, pose, point)) return false;
    if (parts.method == InsideMethod::winding_number) {
        const Vec3 there = pose.inverse()(point);
        const auto triangle_at = [&](std::uint32_t row) { return index.triangle(row); };
        return winding::exceeds(parts.winding, triangle_at, there, 1, 0) ||
               winding::exceeds(parts.winding, triangle_at, there, -1, 0);
    }
    int windings = 0;
    bool odd = false;
    const RayAlongX ray(index, parts.bounds, pose, point);
    visit_rows(
        index, [&](const Vec3& lower, const Vec3& upper) { return ray.may_meet(lower, upper); },
        [&](std::uint32_t row) {
            const int crossing = crossing_ahead(pose(index.triangle(row)), point);
            windings += crossing;
            odd = odd != (crossing != 0);
            return Flow::proceed;
        });
    return parts.method == InsideMethod::crossings ? windings != 0 : odd;
}

ContainmentAnswer find_containment(const Enclosure& a, const Enclosure& b,
                                   const RigidTransform& pose_b) noexcept
{
    const RigidTransform here;
    if (contains_all(b, pose_b, a, here)) return {Containment::a_in_b, b.method()};
    if (contains_all(a, here, b, pose_b)) return {Containment::b_in_a, a.method()};
    return {Containment::none, std::max(a.method(), b.method())};
}

} // namespace proxima
