// The program of docs/tutorial.md, which shows its parts one by one.
#include <cstdio>
#include <exception>
#include <proxima/proxima.h>
#include <vector>

using namespace proxima;

namespace {

int tutorial()
{
    const TriangleMesh mesh = sample_mesh("torus:100x50").value(); // yours: read_mesh("part.stl")
    const MeshIndex index = with_signs(build_mesh_index(mesh).value()).value();
    const std::vector<Vec3> points = {Vec3(0.9, 0, 0.2), Vec3(0, 0, 0), Vec3(1.2, 0.3, 0.8)};
    std::vector<double> distances(points.size());
    if (!signed_distances(index, points, {.distances = distances})) return 1;
    for (const double distance : distances) std::printf("%.4f\n", distance);

    const MeshReport report = report_mesh(mesh).value();
    std::printf("%s, volume %.4f, %zu findings\n", report.closed ? "closed" : "open",
                report.signed_volume.value_or(0), report.findings.size());

    const ClosestFeature closest = closest_feature(index, Vec3(1.2, 0.3, 0.8)).value();
    const Vec3& at = closest.point;
    std::printf("%.4f %.4f %.4f on triangle %u\n", at.x(), at.y(), at.z(),
                to_index(closest.triangle));

    const std::vector<RayHit> hits =
        all_hits(index, {.origin = Vec3(-5, 0.1, 0.2), .direction = Vec3(1, 0, 0)});
    for (const RayHit& hit : hits)
        std::printf("t = %.4f, triangle %u\n", hit.t, to_index(hit.triangle));

    const MeshIndex ball = build_mesh_index(sample_mesh("icosphere:4").value()).value();
    for (const double x : {2.0, 3.0}) {
        const RigidTransform pose{.translation = Vec3(x, 0, 0)};
        const auto pairs = intersecting_pairs(index, ball, pose);
        const double apart = mesh_distance(index, ball, pose).value().distance;
        const double length = intersection_contour(index, ball, pose).length();
        std::printf("%zu pairs meet, along %.3f; %.4f apart\n", pairs.size(), length, apart);
    }

    const Octree octree = build_octree(mesh, {.max_depth = 6, .threshold = 8}).value();
    const OctreeStatistics leaves = octree_statistics(octree);
    std::printf("%zu inner, %zu outer, %zu boundary leaves\n", std::size_t{leaves.inner},
                std::size_t{leaves.outer}, std::size_t{leaves.boundary});
    if (!export_octree(octree, mesh, "octree.vtu")) return 1;

    const DeviceLimits limits = *find_device("omni");
    const WorkspaceMap map = fit_workspace(bounding_box(mesh), limits.workspace_radius);
    HapticRenderer renderer = make_haptic_renderer(index, map, limits).value();
    for (int tick = 0; tick < 1000; ++tick) { // a second: onto the torus, and into it
        DeviceState state;
        state.pose.translation = map.to_device(Vec3(1, 0, 0.8 - 0.0004 * tick));
        renderer.tick(state, 1e-3);
    }
    std::printf("%.3f N, held back at height %.3f\n", renderer.last().force.z(),
                renderer.last().proxy.z());
    return 0;
}

} // namespace

int main()
{
    try {
        return tutorial();
    } catch (const std::exception& error) { // of a value() that is not there
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
