#include "proxima/intersect_meshes.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "index/crossings.h"
#include "index/index_parts.h"
#include "index/signs/sign_parts.h"
#include "mesh/coincidence.h"
#include "query/contact/enclosure_parts.h"

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
    // Layers of an open mesh, or triangles that face different ways, may wind about what is outside of
    // their box.
    if (parts.method == InsideMethod::winding_number) {
        const Vec3 there = pose.inverse()(point);
        const auto triangle_at = [&](std::uint32_t row) { return index.triangle(row); };
        return winding::exceeds(parts.winding, triangle_at, there, 1, 0) ||
               winding::exceeds(parts.winding, triangle_at, there, -1, 0);
    }
    if (surely_outside(parts.bounds, pose, point)) return false;
    int windings = 0;
    bool odd = false;
    visit_crossings(index, parts.bounds, pose, point, [&](std::uint32_t, int crossing) {
        windings += crossing;
        odd = !odd;
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
