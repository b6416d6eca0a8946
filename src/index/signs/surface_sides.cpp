#include "index/signs/surface_sides.h"

#include "base/disjoint_sets.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_distance.h"
#include "index/crossings.h"
#include "index/index_parts.h"
#include "index/signs/sign_geometry.h"
#include "index/visit_near.h"
#include "mesh/surface_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace proxima {

namespace {

constexpr std::size_t triangles_per_task = 512;
constexpr std::size_t patches_per_task = 16;
/// A triangle with more neighbours is taken to meet one: looking at all pairs would take forever.
constexpr int max_tests = 4096;
/// The sine of an angle below which two faces at an edge are not told apart by their distances.
constexpr double thin_wedge = 0x1p-10;

/// What counts as a contact besides one that is exactly.
struct Clearance {
    double distance = 0; ///< triangles with no corner in common that are nearer to each other
    double sine = 0;     ///< of the angle between triangles with a common edge, if that is less
};
constexpr Clearance exact_contact;

bool boxes_meet(const Box& a, const Box& b) noexcept
{
    return (a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

Box grown(const Box& box, double distance) noexcept
{
    return {box.lower - Vec3::Constant(distance), box.upper + Vec3::Constant(distance)};
}

/// The corners of two triangles, those in common first, each at the same position in both.
struct SharedCorners {
    std::array<int, 3> of_a{};
    std::array<int, 3> of_b{};
    int count = 0;
};

SharedCorners share_corners(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    SharedCorners shared;
    std::array<bool, 3> a_used{};
    std::array<bool, 3> b_used{};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (a[static_cast<std::size_t>(i)] != b[static_cast<std::size_t>(k)]) continue;
            const auto next = static_cast<std::size_t>(shared.count++);
            shared.of_a[next] = i;
            shared.of_b[next] = k;
            a_used[static_cast<std::size_t>(i)] = b_used[static_cast<std::size_t>(k)] = true;
        }
    }
    auto a_place = static_cast<std::size_t>(shared.count);
    auto b_place = a_place;
    for (int i = 0; i < 3; ++i) {
        if (!a_used[static_cast<std::size_t>(i)]) shared.of_a[a_place++] = i;
        if (!b_used[static_cast<std::size_t>(i)]) shared.of_b[b_place++] = i;
    }
    return shared;
}

/// Whether two triangles with a common edge from `from` to `to` lie on each other: in one plane,
/// their third corners on one side of the edge.
bool fold_together(const Vec3& from, const Vec3& to, const Vec3& a, const Vec3& b) noexcept
{
    if (orient3d(from, to, a, b) != 0) return false;
    for (int axis = 0; axis < 3; ++axis) {
        const int a_turn = cross_component_sign({from, to}, Displacement{from, a}, axis);
        const int b_turn = cross_component_sign({from, to}, Displacement{from, b}, axis);
        if (a_turn * b_turn != 0) return a_turn == b_turn;
    }
    return true;
}

/// Whether two points are strictly on the same side of a triangle's plane.
bool is_on_one_side(const Triangle& triangle, const Vec3& p, const Vec3& q) noexcept
{
    const int side = orient3d(triangle[0], triangle[1], triangle[2], p);
    return side != 0 && orient3d(triangle[0], triangle[1], triangle[2], q) == side;
}

/// Whether two triangles with areas meet but for the corners and the edge that they share by id.
bool meet_beyond_shared(const TriangleMesh& mesh, TriangleId a_id, TriangleId b_id) noexcept
{
    const Triangle a = mesh.triangle(a_id);
    const Triangle b = mesh.triangle(b_id);
    const SharedCorners shared =
        share_corners(mesh.triangles()[to_index(a_id)], mesh.triangles()[to_index(b_id)]);
    switch (shared.count) {
    case 0:
        return triangles_meet(a, b);
    case 1: // a further point in common implies one on a side opposite the corner
        if (is_on_one_side(a, b[shared.of_b[1]], b[shared.of_b[2]])) return false;
        if (is_on_one_side(b, a[shared.of_a[1]], a[shared.of_a[2]])) return false;
        return segment_meets_triangle(a[shared.of_a[1]], a[shared.of_a[2]], b) ||
               segment_meets_triangle(b[shared.of_b[1]], b[shared.of_b[2]], a);
    case 2:
        return fold_together(a[shared.of_a[0]], a[shared.of_a[1]], a[shared.of_a[2]],
                             b[shared.of_b[2]]);
    default:
        return true;
    }
}

/// The same for a contact that is almost one. `unit` makes the mesh's lengths middling numbers.
bool nearly_meet(const TriangleMesh& mesh, TriangleId a_id, TriangleId b_id,
                 const Clearance& clearance, double unit) noexcept
{
    const auto scaled = [&](TriangleId id) {
        Triangle triangle = mesh.triangle(id);
        for (Vec3& corner : triangle.vertices) corner *= unit;
        return triangle;
    };
    const Triangle a = scaled(a_id);
    const Triangle b = scaled(b_id);
    const SharedCorners shared =
        share_corners(mesh.triangles()[to_index(a_id)], mesh.triangles()[to_index(b_id)]);
    if (shared.count == 0) {
        const double least = clearance.distance * unit;
        return closest_points(a, b).squared_distance < least * least;
    }
    if (shared.count != 2) return false;
    const Vec3 along = unit_of(a[shared.of_a[1]] - a[shared.of_a[0]]);
    const auto across = [&](const Vec3& corner) {
        const Vec3 to = corner - a[shared.of_a[0]];
        return unit_of(to - to.dot(along) * along);
    };
    const Vec3 of_a = across(a[shared.of_a[2]]);
    const Vec3 of_b = across(b[shared.of_b[2]]);
    return of_a.dot(of_b) > 0 && of_a.cross(of_b).norm() < clearance.sine;
}

bool has_area(const TriangleMesh& mesh, TriangleId id) noexcept
{
    return !is_degenerate(mesh.triangle(id));
}

bool meets_another(const IndexParts& tree, const TriangleMesh& mesh,
                   const std::vector<std::uint8_t>& areas, TriangleId id,
                   const Clearance& clearance) noexcept
{
    const Box box = grown(bounding_box(mesh.triangle(id)), clearance.distance);
    const bool nearly = clearance.sine > 0;
    const double unit = tree.scale();
    bool found = false;
    int tests = 0;
    visit_near(tree, box, 0.0, [&](RowRange rows) noexcept {
        for (const TriangleId other : tree.ids().subspan(rows.first, rows.count)) {
            if (other == id || areas[to_index(other)] == 0) continue;
            if (!boxes_meet(box, bounding_box(mesh.triangle(other)))) continue;
            if (++tests <= max_tests && !meet_beyond_shared(mesh, id, other) &&
                !(nearly && nearly_meet(mesh, id, other, clearance, unit)))
                continue;
            found = true;
            return -1.0;
        }
        return 0.0;
    });
    return found;
}

/// Whether every edge of proper triangles has as many each way: winding numbers are whole.
bool is_balanced(const std::vector<detail::EdgeUse>& uses)
{
    return std::ranges::all_of(
        uses, [](const detail::EdgeUse& use) { return use.forward == use.backward; });
}

/// Triangles through which no other surface passes, connected by edges.
struct Patch {
    /// Those of greatest area, descending: where its sides are looked at.
    std::array<TriangleId, 3> largest = {no_triangle, no_triangle, no_triangle};
    std::array<double, 3> areas{};
    SurfaceSides sides = SurfaceSides::doubtful;

    void add(TriangleId id, double area) noexcept
    {
        for (std::size_t i = 0; i < largest.size(); ++i) {
            if (largest[i] != no_triangle && !(area > areas[i])) continue;
            std::swap(area, areas[i]);
            std::swap(id, largest[i]);
            if (id == no_triangle) return;
        }
    }
};

/// Patches and which one each triangle belongs to.
struct Patches {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    std::vector<Patch> items;
    std::vector<std::uint32_t> of_triangle;
};

Patches find_patches(const TriangleMesh& mesh, const Topology& topology,
                     const std::vector<detail::EdgeUse>& uses,
                     const std::vector<std::uint8_t>& contacts)
{
    const auto count = static_cast<std::uint32_t>(mesh.triangle_count());
    std::vector<bool> takes_part(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        takes_part[i] = contacts[i] == 0 && has_area(mesh, TriangleId{i});
    }
    DisjointSets sets(count);
    for (std::uint32_t edge = 0; edge < topology.edge_count(); ++edge) {
        if (uses[edge].total() != 2) continue;
        TriangleId previous = no_triangle;
        for (const TriangleId id : topology.triangles(EdgeId{edge})) {
            if (!takes_part[to_index(id)]) continue;
            if (previous != no_triangle) sets.unite(to_index(previous), to_index(id));
            previous = id;
        }
    }
    Patches patches;
    patches.of_triangle.assign(count, Patches::none);
    const double scale = 1.0 / bounding_box(mesh).extent().maxCoeff();
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!takes_part[i]) continue;
        const std::uint32_t first = sets.find(i);
        if (first == i) {
            patches.of_triangle[i] = static_cast<std::uint32_t>(patches.items.size());
            patches.items.emplace_back();
        }
        patches.of_triangle[i] = patches.of_triangle[first];
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vec3 a = (triangle[1] - triangle[0]) * scale;
        const Vec3 b = (triangle[2] - triangle[0]) * scale;
        patches.items[patches.of_triangle[i]].add(TriangleId{i}, a.cross(b).norm());
    }
    return patches;
}

/// Whether any but this triangle is within a distance of a point.
bool is_near_another(const IndexParts& index, TriangleId id, const Vec3& p, double distance)
{
    // In the frame, where squares neither vanish nor overflow.
    const double scale = index.scale();
    const double reach = distance * scale;
    NearWalk walk(index, {p, p}, reach * reach);
    while (const IndexLeaf* const leaf = walk.next_leaf()) {
        for (std::uint32_t row = leaf->first_row; row < leaf->first_row + leaf->count; ++row) {
            if (index.id(row) == id) continue;
            Triangle seen = index.triangle(row);
            for (Vec3& corner : seen.vertices) corner = (corner - p) * scale;
            if (closest_point(seen, Vec3::Zero()).point.norm() <= reach) return true;
        }
    }
    return false;
}

/// The winding number in front of a triangle; nothing where rounding its middle may take that past
/// another triangle. \pre winding numbers are whole
std::optional<int> winding_in_front(const IndexParts& index, const Box& bounds,
                                    const TriangleMesh& mesh, TriangleId id)
{
    constexpr double rounding = 0x1p-48; // more than that of the middle, in its coordinates
    const Triangle triangle = mesh.triangle(id);
    const Vec3 middle =
        triangle[0] + ((triangle[1] - triangle[0]) + (triangle[2] - triangle[0])) / 3.0;
    double size = 0;
    for (const Vec3& corner : triangle.vertices)
        size = std::max(size, corner.cwiseAbs().maxCoeff());
    if (is_near_another(index, id, middle, rounding * size)) return std::nullopt;
    int axis = 0;
    unit_normal_of(triangle).cwiseAbs().maxCoeff(&axis);
    const int along = cross_component_sign({triangle[0], triangle[1]},
                                           Displacement{triangle[0], triangle[2]}, axis);
    if (along == 0) return std::nullopt;
    const RigidTransform turn = turn_to_x(axis);
    int others = 0;
    visit_crossings(index, bounds, turn, turn(middle), [&](std::uint32_t row, int crossing) {
        if (index.id(row) != id) others += crossing;
    });
    // A ray that leaves backwards begins behind the triangle, where the number is one more.
    return along > 0 ? others : others - 1;
}

SurfaceSides sides_of(const Patch& patch, const IndexParts& index, const Box& bounds,
                      const TriangleMesh& mesh)
{
    std::optional<int> front;
    for (const TriangleId id : patch.largest) {
        if (id == no_triangle) continue;
        const auto found = winding_in_front(index, bounds, mesh, id);
        if (!found || (front && *front != *found)) return SurfaceSides::doubtful;
        front = found;
    }
    if (!front) return SurfaceSides::doubtful;
    if (*front == 0) return SurfaceSides::separates;
    return *front > 0 ? SurfaceSides::inside_both : SurfaceSides::outside_both;
}

Result<std::vector<std::uint8_t>> find_contacts(const IndexParts& tree, const TriangleMesh& mesh,
                                                const Clearance& clearance,
                                                const SurfaceSidesOptions& options)
{
    const std::size_t count = mesh.triangle_count();
    std::vector<std::uint8_t> areas(count, 0);
    std::vector<std::uint8_t> contacts(count, 0);
    const auto for_all = [&](const auto& visit) {
        parallel_chunks(count, triangles_per_task, options.execution.threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(options.execution.progress)) return;
                            for (std::size_t i = first; i < end; ++i) visit(i);
                            advance_stage(options.execution.progress, end - first);
                        });
    };
    begin_stage(options.execution.progress, "self-contacts", 2 * count);
    for_all([&](std::size_t i) {
        areas[i] = has_area(mesh, TriangleId{static_cast<std::uint32_t>(i)}) ? 1 : 0;
    });
    // By row: neighbours share what the caches hold.
    for_all([&](std::size_t row) {
        const TriangleId id = tree.ids()[row];
        if (areas[to_index(id)] == 0) return;
        contacts[to_index(id)] = meets_another(tree, mesh, areas, id, clearance) ? 1 : 0;
    });
    if (is_cancelled(options.execution.progress))
        return cancelled("finding the sides of the surface");
    return contacts;
}

/// What distances of points within the mesh's box round must not bridge: 2^-50 of them, of which
/// this is well above.
Clearance clearance_of(const TriangleMesh& mesh) noexcept
{
    const Box box = bounding_box(mesh);
    return {.distance = 0x1p-45 * box.extent().maxCoeff(), .sine = thin_wedge};
}

} // namespace

Result<std::vector<std::uint8_t>> find_self_contacts(const MeshIndex& index,
                                                     const TriangleMesh& mesh,
                                                     const SurfaceSidesOptions& options)
{
    return find_contacts(index.parts(), mesh, exact_contact, options);
}

Result<std::vector<SurfaceSides>> find_surface_sides(const MeshIndex& index,
                                                     const TriangleMesh& mesh,
                                                     const Topology& topology,
                                                     const SurfaceSidesOptions& options)
{
    const auto uses = detail::edge_uses(mesh, topology);
    if (!is_balanced(uses)) return std::vector<SurfaceSides>();
    const auto contacts = find_contacts(index.parts(), mesh, clearance_of(mesh), options);
    if (!contacts) return tl::unexpected(contacts.error());
    Patches patches = find_patches(mesh, topology, uses, *contacts);
    const std::size_t count = patches.items.size();
    const Box bounds = bounding_box(mesh);
    begin_stage(options.execution.progress, "surface sides", count);
    parallel_chunks(count, patches_per_task, options.execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(options.execution.progress)) return;
                        for (std::size_t i = first; i < end; ++i) {
                            patches.items[i].sides =
                                sides_of(patches.items[i], index.parts(), bounds, mesh);
                        }
                        advance_stage(options.execution.progress, end - first);
                    });
    if (is_cancelled(options.execution.progress))
        return cancelled("finding the sides of the surface");
    std::vector<SurfaceSides> sides(mesh.triangle_count(), SurfaceSides::doubtful);
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const std::uint32_t patch = patches.of_triangle[i];
        if (patch != Patches::none) sides[i] = patches.items[patch].sides;
    }
    return sides;
}

} // namespace proxima
