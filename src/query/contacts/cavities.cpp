#include "query/contacts/cavities.h"

#include "base/disjoint_sets.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/crossings.h"
#include "index/index_parts.h"
#include "mesh/coincidence.h"
#include "mesh/surface_parts.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace proxima {

namespace {

constexpr std::uint32_t no_component = ~std::uint32_t{0};
constexpr std::uint32_t several_components = no_component - 1;

/// By each vertex's position: the component of the triangles there, or several.
std::vector<std::uint32_t> components_at_vertices(const TriangleMesh& mesh,
                                                  const std::vector<std::uint32_t>& first,
                                                  const std::vector<std::uint32_t>& components)
{
    std::vector<std::uint32_t> at(mesh.vertex_count(), no_component);
    for (std::uint32_t t = 0; t < components.size(); ++t) {
        if (components[t] == no_component) continue;
        for (const std::uint32_t corner : mesh.triangles()[t]) {
            std::uint32_t& there = at[first[corner]];
            const bool is_same = there == no_component || there == components[t];
            there = is_same ? components[t] : several_components;
        }
    }
    for (std::size_t v = 0; v < at.size(); ++v) at[v] = at[first[v]];
    return at;
}

/// For every triangle the lowest one that edges connect it with; vertices at one position are one. No
/// component of triangles without three different ones.
std::vector<std::uint32_t> components_of(const TriangleMesh& mesh,
                                         const std::vector<std::uint32_t>& first)
{
    struct Side {
        std::uint64_t vertices;
        std::uint32_t triangle;
    };
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangle_count());
    std::vector<std::uint32_t> components(mesh.triangle_count(), no_component);
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        TriangleCorners corners = mesh.triangles()[t];
        for (std::uint32_t& corner : corners) corner = first[corner];
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
            continue;
        components[t] = t;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % 3]);
            sides.push_back({std::uint64_t{low} << 32U | high, t});
        }
    }
    std::ranges::sort(sides, {}, &Side::vertices);
    DisjointSets sets(mesh.triangle_count());
    Side before = {~std::uint64_t{0}, 0}; // of no side
    for (const Side& side : sides) {
        if (side.vertices == before.vertices) sets.unite(side.triangle, before.triangle);
        before = side;
    }
    for (std::uint32_t& component : components)
        if (component != no_component) component = sets.find(component);
    return components;
}

/// Signed, by component, as report_mesh sums them up: from a vertex of the component, as from farther away
/// rounding would hide small ones.
std::vector<detail::VolumeSum> volumes_of(const TriangleMesh& mesh,
                                          const std::vector<std::uint32_t>& components)
{
    static_assert(no_component == detail::no_surface_sum);
    std::vector<detail::VolumeSum> volumes =
        detail::scaled_sums(mesh, components, mesh.triangle_count());
    for (std::uint32_t t = 0; t < components.size(); ++t) {
        if (components[t] == no_component) continue;
        const Vec3 origin = mesh.triangle(TriangleId{components[t]})[0];
        volumes[components[t]].add(mesh.triangle(TriangleId{t}), origin);
    }
    return volumes;
}

tl::unexpected<Error> refuse(std::uint32_t component, std::string_view what)
{
    return fail(ErrorCode::invalid_mesh,
                concat("the component with triangle ", component, " faces inward ", what));
}

} // namespace

Status check_cavities(const MeshIndex& index, const TriangleMesh& mesh, const Execution& execution)
{
    const std::vector<std::uint32_t> first = detail::first_at_position(mesh);
    const std::vector<std::uint32_t> components = components_of(mesh, first);
    const std::vector<detail::VolumeSum> volumes = volumes_of(mesh, components);
    std::vector<TriangleId> inward;
    std::vector<TriangleId> outward;
    for (std::uint32_t t = 0; t < components.size(); ++t) {
        if (components[t] == no_component) continue;
        (volumes[components[t]].volume < 0 ? inward : outward).push_back(TriangleId{t});
    }
    const auto inner = build_mesh_index(sub_mesh(mesh, inward), {.execution = execution});
    if (!inner) return tl::unexpected(inner.error());
    const auto outer = build_mesh_index(sub_mesh(mesh, outward), {.execution = execution});
    if (!outer) return tl::unexpected(outer.error());
    const auto component_of = [&](TriangleId in_sub_mesh) {
        return components[to_index(inward[to_index(in_sub_mesh)])];
    };
    constexpr std::string_view needed = ": a cavity must be apart from all other components";
    if (const auto meeting = find_meeting(*inner, *outer)) {
        return refuse(component_of(meeting->triangle_a),
                      concat("and touches one that faces outward", needed));
    }
    const auto touches = find_self_intersections(*inner, {.max_pairs = 1, .execution = execution});
    if (!touches) return tl::unexpected(touches.error());
    if (!touches->pairs.empty()) {
        return refuse(component_of(touches->pairs.front().a),
                      concat("and touches itself or another such", needed));
    }
    const Box bounds = bounding_box(mesh);
    const auto winding_of_others = [&](std::uint32_t component, std::uint32_t vertex) {
        int winding = 0;
        visit_crossings(index.parts(), bounds, {}, mesh.positions()[vertex],
                        [&](std::uint32_t row, int crossing) {
                            const std::uint32_t other = components[to_index(index.ids()[row])];
                            if (other != component && other != no_component) winding += crossing;
                        });
        return winding;
    };
    // At a vertex that other cavities have, too, the winding number may be that on either side of them:
    // only a vertex of its own tells where a component is.
    const std::vector<std::uint32_t> at_vertices = components_at_vertices(mesh, first, components);
    std::vector<bool> is_inside(mesh.triangle_count(), false); // by component
    for (const TriangleId triangle : inward) {
        const std::uint32_t component = components[to_index(triangle)];
        for (const std::uint32_t corner : mesh.triangles()[to_index(triangle)]) {
            if (is_inside[component] || at_vertices[corner] != component) continue;
            if (winding_of_others(component, corner) < 1) {
                return refuse(component, "and is in nothing that it could be a cavity of: turn it "
                                         "(proxima repair)");
            }
            is_inside[component] = true;
            if (is_cancelled(execution.progress)) return cancelled("checking cavities");
        }
    }
    for (const TriangleId triangle : inward) {
        const std::uint32_t component = components[to_index(triangle)];
        if (!is_inside[component]) {
            return refuse(component, "and shares all its vertices with other such: a cavity must "
                                     "have one of its own");
        }
    }
    return {};
}

} // namespace proxima
