#include "lab/nasty_check.h"

#include "base/text.h"
#include "geometry/test_volumes.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_distance.h"
#include "geometry/view_contact.h"
#include "index/check_structure.h"
#include "index/test_meshes.h"
#include "octree/check_octree.h"
#include "oracles/exact_winding.h"
#include "oracles/ray_hits.h"
#include "proxima/cast_ray.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/cull.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/index_io.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/mesh_repair.h"
#include "proxima/mesh_report.h"
#include "proxima/minkowski_sum.h"
#include "proxima/octree.h"
#include "proxima/signed_distance.h"
#include "proxima/touch_scene.h"
#include "query/closest/brute_force.h"
#include "query/contact/self_intersection.h"
#include "query/contact/test_poses.h"
#include "query/rays/test_rays.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

namespace proxima::testing {
namespace {

using oracle::NastyMesh;

constexpr std::size_t few_triangles = 1000;    ///< of which all pairs are looked at
constexpr std::size_t many_triangles = 10'000; ///< which not all operations can do round a vertex

/// Collects what came of an operation.
class Comparison {
public:
    /// Counts a comparison; `what` says what it was about where it failed.
    bool expect(bool right, const std::string& what)
    {
        ++outcome_.comparisons;
        if (!right && outcome_.wrong.empty()) outcome_.wrong = what;
        return right;
    }

    /// Whether there is a result. Where there is none, it has to say why.
    template <class T>
    bool has(const Result<T>& result)
    {
        return result ? true : refused(result.error());
    }
    bool has(const Status& status) { return status ? true : refused(status.error()); }

    void leave_out() { outcome_.left_out = true; }

    [[nodiscard]] const NastyOutcome& outcome() const { return outcome_; }

private:
    bool refused(const Error& error)
    {
        outcome_.refusal = describe(error);
        if (error.message.size() < 10 || error.code == ErrorCode::broken_invariant)
            outcome_.wrong = concat("refused without a reason: ", outcome_.refusal);
        return false;
    }

    NastyOutcome outcome_;
};

/// A mesh with what most operations need.
struct Subject {
    const NastyMesh& nasty;
    const NastyEffort& effort;
    const TriangleMesh& mesh = nasty.mesh;
    Topology topology = build_topology(mesh).value();
    MeshIndex index = build_mesh_index(mesh).value();
    std::vector<Vec3> points = proximity_points(mesh, effort.queries, 3);
    double reach = std::max(bounding_box(mesh).lower.cwiseAbs().maxCoeff(),
                            bounding_box(mesh).upper.cwiseAbs().maxCoeff());

    [[nodiscard]] bool is_small() const { return mesh.triangle_count() <= few_triangles; }
    [[nodiscard]] bool is_large() const { return mesh.triangle_count() > many_triangles; }
};

std::string text_of(const Vec3& p)
{
    return concat(p.x(), ' ', p.y(), ' ', p.z());
}

std::string text_of(const ClosestFeature& closest)
{
    return concat("kind ", static_cast<int>(closest.feature.kind), " id ", closest.feature.id,
                  " at ", text_of(closest.point), " of squared distance ",
                  closest.squared_distance);
}

void check_report(const Subject& on, Comparison& to)
{
    const auto report = report_mesh(on.mesh);
    if (!to.has(report)) return;
    to.expect(report->triangles == on.mesh.triangle_count(), "its number of triangles");
    if (on.nasty.is_closed)
        to.expect(report->closed && report->consistently_oriented, "closed and oriented");
}

void check_repair(const Subject& on, Comparison& to)
{
    const auto once = repair_mesh(on.mesh);
    if (!to.has(once)) return;
    const auto twice = repair_mesh(once->mesh);
    if (!to.has(twice)) return;
    to.expect(mesh_fingerprint(once->mesh) == mesh_fingerprint(twice->mesh), "repaired again");
}

void check_octrees(const Subject& on, Comparison& to)
{
    const auto octree = build_octree(on.mesh, {.max_depth = on.is_small() ? 5 : 3});
    if (!to.has(octree)) return;
    const Status sound = check_octree(*octree, on.mesh);
    to.expect(sound.has_value(), sound ? "" : describe(sound.error()));
}

void check_index(const Subject& on, Comparison& to)
{
    const Status sound = check_structure(on.index);
    to.expect(sound.has_value(), sound ? "" : describe(sound.error()));
    const auto mesh = mesh_of(on.index);
    if (!to.has(mesh)) return;
    to.expect(mesh_fingerprint(*mesh) == mesh_fingerprint(on.mesh), "its mesh");
}

bool is_same(const ClosestFeature& a, const ClosestFeature& b)
{
    return a.feature == b.feature && a.triangle == b.triangle && a.point == b.point &&
           a.barycentric == b.barycentric && a.squared_distance == b.squared_distance;
}

void compare_closest(const Subject& on, const MeshIndex& index, Comparison& to)
{
    for (const Vec3& p : on.points) {
        const auto found = closest_feature(index, p);
        if (!to.expect(found.has_value(), "an answer")) continue;
        const auto truth = closest_feature_by_brute_force(on.mesh, on.topology, p);
        to.expect(is_same(*found, truth),
                  concat("from ", text_of(p), ": ", text_of(*found), ", not ", text_of(truth)));
    }
}

void check_closest(const Subject& on, Comparison& to)
{
    compare_closest(on, on.index, to);
}

void check_lists(const Subject& on, Comparison& to)
{
    if (on.is_large()) return to.leave_out();
    const auto listed = with_lists(on.index);
    if (to.has(listed)) compare_closest(on, *listed, to);
}

void check_signs(const Subject& on, Comparison& to)
{
    if (on.is_large()) return to.leave_out();
    const auto index = with_signs(on.index);
    if (!to.has(index)) return;
    for (const Vec3& p : on.points) {
        const auto found = signed_distance(*index, p);
        if (!to.expect(found.has_value(), "an answer") || !on.nasty.is_closed) continue;
        // Within rounding of the surface either side will do.
        if (std::abs(found->distance) <= 1e-14 * (on.reach + p.cwiseAbs().maxCoeff())) continue;
        const auto winding = oracle::exact_winding(on.mesh, p);
        if (winding) to.expect((found->distance < 0) == (*winding >= 1), concat("at ", text_of(p)));
    }
}

void check_rays(const Subject& on, Comparison& to)
{
    RayGenerator generate(on.mesh, 7);
    for (int i = 0; i < on.effort.queries; ++i) {
        const Ray ray = generate();
        to.expect(all_hits(on.index, ray) == all_hits_by_brute_force(on.mesh, ray),
                  concat("ray ", i));
        to.expect(closest_hit(on.index, ray, Faces::front) ==
                      closest_hit_by_brute_force(on.mesh, ray, Faces::front),
                  concat("front of ray ", i));
    }
}

/// The mesh itself, or of a large one twelve triangles of it.
TriangleMesh other_mesh(const Subject& on)
{
    if (on.is_small()) return on.mesh;
    std::vector<TriangleId> some;
    for (std::uint32_t i = 0; i < 12; ++i)
        some.push_back(TriangleId{i * static_cast<std::uint32_t>(on.mesh.triangle_count() / 12)});
    return sub_mesh(on.mesh, some);
}

void check_pairs(const Subject& on, Comparison& to)
{
    const TriangleMesh other = other_mesh(on);
    const MeshIndex index = build_mesh_index(other).value();
    PoseGenerator generate(on.mesh, other, 5);
    for (int i = 0; i < on.effort.queries / 4; ++i) {
        const RigidTransform pose = generate();
        const auto truth = pairs_by_brute_force(on.mesh, other, pose);
        to.expect(intersecting_pairs(on.index, index, pose) == truth, concat("pose ", i));
        to.expect(meshes_intersect(on.index, index, pose) == !truth.empty(), concat("pose ", i));
    }
}

void check_distances(const Subject& on, Comparison& to)
{
    const TriangleMesh other = other_mesh(on);
    const MeshIndex index = build_mesh_index(other).value();
    PoseGenerator generate(on.mesh, other, 6);
    for (int i = 0; i < on.effort.queries / 8; ++i) {
        const RigidTransform pose = generate();
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t k = 0; k < other.triangle_count(); ++k) {
            const Triangle moved = pose(other.triangle(TriangleId{k}));
            for (std::uint32_t j = 0; j < on.mesh.triangle_count(); ++j) {
                const auto pair = closest_points(on.mesh.triangle(TriangleId{j}), moved);
                least = std::min(least, std::sqrt(pair.squared_distance));
            }
        }
        const auto found = mesh_distance(on.index, index, pose);
        const double size = on.reach + pose.translation.norm();
        to.expect(found && std::abs(found->distance - least) <= 1e-12 * size &&
                      (found->distance == 0) == (least == 0),
                  concat("pose ", i));
    }
}

void check_self_intersections(const Subject& on, Comparison& to)
{
    if (on.is_large()) return to.leave_out();
    const auto found = find_self_intersections(on.index);
    if (!to.has(found)) return;
    for (const TrianglePair& pair : found->pairs) {
        to.expect(triangles_meet(on.mesh.triangle(pair.a), on.mesh.triangle(pair.b)),
                  concat("triangles ", to_index(pair.a), " and ", to_index(pair.b)));
    }
    if (!on.is_small() || !found->complete) return;
    std::vector<TrianglePair> truth;
    for (std::uint32_t i = 0; i < on.mesh.triangle_count(); ++i) {
        for (std::uint32_t j = i + 1; j < on.mesh.triangle_count(); ++j) {
            if (meet_beyond_corners(on.mesh.triangle(TriangleId{i}),
                                    on.mesh.triangle(TriangleId{j})))
                truth.push_back({TriangleId{i}, TriangleId{j}});
        }
    }
    to.expect(found->pairs == truth, "all pairs");
}

void check_view_volumes(const Subject& on, Comparison& to)
{
    VolumeGenerator generate(on.mesh.positions(), 8);
    for (int i = 0; i < on.effort.queries / 2; ++i) {
        const ViewVolume volume = generate();
        std::vector<TriangleId> truth;
        for (std::uint32_t k = 0; k < on.mesh.triangle_count(); ++k) {
            if (meets_volume(volume, on.mesh.triangle(TriangleId{k})))
                truth.push_back(TriangleId{k});
        }
        to.expect(visible_triangles(on.index, volume, CullMode::exact) == truth,
                  concat("volume ", i));
    }
}

/// A sum with a set that holds the origin holds all vertices.
void expect_vertices(const Subject& on, const MinkowskiSum& sum, Comparison& to)
{
    const std::size_t step = on.is_small() ? 1 : on.mesh.vertex_count() / 50;
    for (std::size_t i = 0; i < on.mesh.vertex_count(); i += step)
        to.expect(contains(sum, on.mesh.positions()[i]), concat("vertex ", i));
}

void check_hull(const Subject& on, Comparison& to)
{
    const auto hull = convex_hull(on.mesh.positions());
    if (!to.has(hull)) return;
    const double size = bounding_box(on.mesh).extent().maxCoeff();
    const auto box = polyhedron_of_box({Vec3::Constant(-size), Vec3::Constant(2 * size)});
    if (!to.has(box)) return;
    for (const ConvexPolyhedron& other :
         {*box, convex_hull(std::array{Vec3(Vec3::Zero())}).value()}) {
        const auto sum = minkowski_sum(*hull, other);
        if (to.has(sum)) expect_vertices(on, *sum, to);
    }
}

void check_polyhedron(const Subject& on, Comparison& to)
{
    if (on.is_large()) return to.leave_out();
    const auto polyhedron = polyhedron_of_mesh(on.mesh);
    if (!to.has(polyhedron)) return;
    const auto sum =
        minkowski_sum(*polyhedron, convex_hull(std::array{Vec3(Vec3::Zero())}).value());
    if (to.has(sum)) expect_vertices(on, *sum, to);
}

void check_touch(const Subject& on, Comparison& to)
{
    if (on.is_large()) return to.leave_out(); // it wants signs
    const DeviceLimits limits = *find_device("omni");
    auto renderer = make_haptic_renderer(
        on.index, fit_workspace(bounding_box(on.mesh), limits.workspace_radius), limits);
    if (!to.has(renderer)) return;
    for (int i = 0; i < on.effort.ticks; ++i) {
        DeviceState state;
        const double t = static_cast<double>(i) / on.effort.ticks;
        state.pose.translation = limits.workspace_radius * Vec3(0.9 - 1.5 * t, 0.1 * t, 0.03);
        const RenderTick& tick = renderer->tick(state, 1e-3);
        to.expect(tick.force.allFinite() && tick.force.norm() <= limits.max_force,
                  concat("tick ", i));
    }
}

void check_files(const Subject& on, Comparison& to)
{
    const std::filesystem::path mesh_file = on.effort.folder / "nasty.ply";
    const std::filesystem::path index_file = on.effort.folder / "nasty.pxi";
    if (to.has(write_mesh(on.mesh, mesh_file))) {
        const auto mesh = read_mesh(mesh_file);
        if (to.has(mesh))
            to.expect(mesh_fingerprint(*mesh) == mesh_fingerprint(on.mesh), "the mesh read");
    }
    if (to.has(save_index(on.index, index_file))) {
        const auto index = load_index(index_file);
        if (to.has(index)) compare_closest(on, *index, to);
    }
    std::filesystem::remove(mesh_file);
    std::filesystem::remove(index_file);
}

struct Operation {
    const char* name;
    void (*check)(const Subject&, Comparison&);
};

constexpr Operation operations[] = {{"report", check_report},
                                    {"repair", check_repair},
                                    {"octree", check_octrees},
                                    {"index", check_index},
                                    {"closest feature", check_closest},
                                    {"closest feature by lists", check_lists},
                                    {"signed distance", check_signs},
                                    {"rays", check_rays},
                                    {"intersecting pairs", check_pairs},
                                    {"distance of meshes", check_distances},
                                    {"self-intersections", check_self_intersections},
                                    {"view volumes", check_view_volumes},
                                    {"convex hull and sums", check_hull},
                                    {"convex polyhedron", check_polyhedron},
                                    {"touch", check_touch},
                                    {"files", check_files}};

} // namespace

std::vector<std::string> nasty_operations()
{
    std::vector<std::string> names;
    for (const Operation& operation : operations) names.emplace_back(operation.name);
    return names;
}

std::vector<NastyOutcome> check_nasty(const NastyMesh& nasty, const NastyEffort& effort)
{
    const Subject subject{nasty, effort};
    std::vector<NastyOutcome> outcomes;
    for (const Operation& operation : operations) {
        Comparison comparison;
        const auto begin = std::chrono::steady_clock::now();
        operation.check(subject, comparison);
        outcomes.push_back(comparison.outcome());
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
        outcomes.back().seconds = passed.count();
    }
    return outcomes;
}

} // namespace proxima::testing
