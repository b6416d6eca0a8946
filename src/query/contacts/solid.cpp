#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "index/index_parts.h"
#include "mesh/coincidence.h"
#include "proxima/mesh_report.h"
#include "proxima/signed_distance.h"
#include "query/contact/enclosure_parts.h"
#include "query/contacts/cavities.h"
#include "query/contacts/overlap.h"
#include "query/contacts/solid_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

/// The mesh with one vertex for each position, times a power of two.
Result<TriangleMesh> welded(const TriangleMesh& mesh, double scale)
{
    const std::vector<std::uint32_t> first = detail::first_at_position(mesh);
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    for (Vec3& p : positions) p *= scale;
    std::vector<TriangleCorners> triangles;
    triangles.reserve(mesh.triangle_count());
    for (TriangleCorners corners : mesh.triangles()) {
        for (std::uint32_t& corner : corners) corner = first[corner];
        const bool has_three =
            corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0];
        if (has_three) triangles.push_back(corners);
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

/// That the surface bounds a solid: closed, oriented, every component outward or a cavity's.
Status check_solid(const MeshIndex& index, const TriangleMesh& mesh, const Execution& execution)
{
    const auto whole = welded(mesh, index.parts().scale()); // volumes of this size are numbers
    if (!whole) return tl::unexpected(whole.error());
    const auto report = report_mesh(*whole, {.execution = execution});
    if (!report) return tl::unexpected(report.error());
    const auto refuse = [](std::string what) {
        return fail(ErrorCode::invalid_mesh, std::move(what));
    };
    if (!report->closed) {
        const MeshFinding* const open = report->find(FindingKind::boundary_edges);
        if (open == nullptr)
            return refuse("no triangle of the mesh has an area, so it has no inside");
        return refuse(
            concat("the mesh is open: ", open->count,
                   " edges have one triangle, and only a closed mesh has an inside; close "
                   "its holes, or take its convex hull"));
    }
    if (!report->consistently_oriented) {
        return refuse("triangles of the closed mesh face different ways, so it has no inside: turn "
                      "them (proxima repair)");
    }
    if (report->orientation == Orientation::mixed) return check_cavities(index, mesh, execution);
    if (report->orientation == Orientation::inward)
        return refuse("the mesh is turned inside out: turn its triangles (proxima repair)");
    if (report->orientation != Orientation::outward)
        return refuse("a component of the mesh has no volume, so it has no inside: leave it out");
    return {};
}

/// How far points of a hull may be from the mesh, no vertex of which is more than `excess` beyond a
/// triangle's plane: the hull shrunk about an inner point by excess / radius is within the mesh,
/// where radius is that of a ball about the point that all planes leave inside.
double hull_error_of(const ConvexPolyhedron& hull, double excess)
{
    // From one of the corners, so that roundings are those of the hull's size, wherever it is.
    std::vector<Vec3> points(hull.points().begin(), hull.points().end());
    for (Vec3& p : points) p -= hull.points().front();
    Vec3 center = Vec3::Zero();
    for (const Vec3& p : points) center += p / static_cast<double>(points.size());
    double radius = HUGE_VAL;
    for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
        const Vec3 normal = hull.half_space(f).normal;
        double distance = -HUGE_VAL;
        for (const std::uint32_t corner : hull.facet_loop(f))
            distance = std::max(distance, normal.dot(points[corner] - center));
        radius = std::min(radius, distance);
    }
    double reach = 0;
    for (const Vec3& p : points) reach = std::max(reach, length_of(p - center));
    excess += 0x1p-47 * reach; // roundings of heights above planes, 2^-49 of the diagonal at most
    return radius > 2 * excess ? excess / (radius - excess) * reach : HUGE_VAL;
}

/// Whether the whole hull is on the inner side of all triangles' planes, exactly: then the mesh,
/// which is closed and faces outward, is its hull. Of small meshes: false of others.
bool is_its_hull(const TriangleMesh& mesh, const ConvexPolyhedron& hull)
{
    constexpr std::size_t most = 1 << 20; // signs of determinants, about 10 ms
    if (mesh.triangle_count() * hull.points().size() > most) return false;
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{static_cast<std::uint32_t>(t)});
        const bool is_outmost = std::ranges::all_of(hull.points(), [&](const Vec3& p) {
            return orient3d(triangle[0], triangle[1], triangle[2], p) <= 0;
        });
        if (!is_outmost) return false;
    }
    return true;
}

bool have_same_corners(const ConvexPolyhedron& a, const ConvexPolyhedron& b)
{
    const auto sorted_corners = [](const ConvexPolyhedron& hull) {
        std::vector<Vec3> corners(hull.points().begin(), hull.points().end());
        std::ranges::sort(corners, [](const Vec3& p, const Vec3& q) {
            return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
        });
        return corners;
    };
    return sorted_corners(a) == sorted_corners(b);
}

/// Whether the mesh is its hull: exactly, or by the smallest of a few tolerances that it passes.
void find_convexity(SolidParts& parts, const TriangleMesh& mesh, const Execution& execution)
{
    if (is_its_hull(mesh, parts.hull)) {
        parts.is_convex = true;
        parts.hull_error = 0;
        return;
    }
    const auto whole = welded(mesh, 1); // triangles of a soup have neighbours, too
    if (!whole) return;
    const double diagonal = length_of(bounding_box(mesh).extent());
    for (const double tolerance : {1e-9, 1e-12, 0x1p-50}) {
        const auto hull = polyhedron_of_mesh(*whole, {tolerance, execution});
        if (!hull) return;
        // Triangles of fewer than three corners, which `whole` is without, may reach out of it.
        if (!have_same_corners(*hull, parts.hull)) return;
        const double error = hull_error_of(parts.hull, tolerance * diagonal);
        if (!(error < 0.1 * diagonal)) continue;
        parts.is_convex = true;
        parts.hull_error = error;
    }
}

} // namespace

Solid::Solid(std::shared_ptr<const SolidParts> parts) noexcept : parts_(std::move(parts)) {}

const MeshIndex& Solid::index() const noexcept
{
    return parts_->index;
}

const Enclosure& Solid::enclosure() const noexcept
{
    return parts_->enclosure;
}

bool Solid::is_convex() const noexcept
{
    return parts_->is_convex;
}

double Solid::hull_error() const noexcept
{
    return parts_->hull_error;
}

Result<Solid> build_solid(const MeshIndex& index, const SolidOptions& options)
{
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto bounds = checked_bounding_box(*mesh);
    if (!bounds) return tl::unexpected(bounds.error());
    const Execution& execution = options.execution;
    if (Status status = check_solid(index, *mesh, execution); !status)
        return tl::unexpected(status.error());
    std::vector<bool> is_used(mesh->vertex_count(), false);
    for (const TriangleCorners& corners : mesh->triangles())
        for (const std::uint32_t corner : corners) is_used[corner] = true;
    std::vector<Vec3> points;
    for (std::size_t v = 0; v < is_used.size(); ++v)
        if (is_used[v]) points.push_back(mesh->positions()[v]);
    auto hull = convex_hull(points, {}, execution);
    if (!hull) return tl::unexpected(hull.error());
    if (hull->dimension() < 3) {
        return fail(ErrorCode::invalid_mesh,
                    "the mesh has no volume: all its vertices lie in one plane");
    }
    auto with =
        index.has_signs() ? Result<MeshIndex>(index) : with_signs(index, {.execution = execution});
    if (!with) return tl::unexpected(with.error());
    auto enclosure = build_enclosure(*with, {.execution = execution});
    if (!enclosure) return tl::unexpected(enclosure.error());
    auto parts = std::make_shared<SolidParts>(SolidParts{
        .mesh = *mesh, .index = *with, .enclosure = *enclosure, .hull = std::move(*hull)});
    parts->largest =
        std::max(bounds->lower.cwiseAbs().maxCoeff(), bounds->upper.cwiseAbs().maxCoeff());
    find_convexity(*parts, *mesh, execution);
    if (is_cancelled(execution.progress)) return cancelled("preparing a solid");
    return Solid(std::move(parts));
}

bool SolidOverlap::operator()(const RigidTransform& pose_b) noexcept
{
    const MeshIndex& index_a = a_.index;
    const MeshIndex& index_b = b_.index;
    if (const auto found = find_meeting(index_a, index_b, pose_b, {.start_from = &last_})) {
        last_ = *found;
        return true;
    }
    // Surfaces are apart: every connected part is inside or outside as a whole.
    const RigidTransform here;
    const auto inside = [](const SolidParts& outer, const RigidTransform& outer_pose,
                           const SolidParts& inner, const RigidTransform& inner_pose) {
        return std::ranges::any_of(inner.enclosure.parts().vertices, [&](const Vec3& vertex) {
            return encloses(outer.enclosure, outer_pose, inner_pose(vertex));
        });
    };
    return inside(a_, here, b_, pose_b) || inside(b_, pose_b, a_, here);
}

bool solids_overlap(const Solid& a, const Solid& b, const RigidTransform& pose_b) noexcept
{
    return SolidOverlap(a.parts(), b.parts())(pose_b);
}

} // namespace proxima
