// View-volume culling beside brute force by vector lanes: passes in turn, medians and ratios.
//
//     cull_bench [--views N] [--rounds N] [--seed N] [--mesh NAME]...
//
// For every part of the triangles (0, 0.1, 10, 50, 100 %) some cameras that see about that many.
// All answers are compared: brute force, in floats, may differ in a few triangles. One thread. Then
// a camera turns about the mesh in steps: what frames take, and what the one before could spare.
#include "bench_program.h"
#include "cull_by_lanes.h"
#include "cull_path.h"
#include "proxima/cull.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <random>

namespace proxima::bench {
namespace {

struct BenchOptions : CommonOptions {
    int views = 8;
};

/// A mesh, and all that is culled with.
struct Scene {
    TriangleMesh mesh;
    MeshIndex index;
    std::vector<TriangleCorners> sorted; ///< corners in the index's order
    TriangleArrays by_id;
    TriangleArrays by_row;
    VertexArrays vertices_by_id;
    VertexArrays vertices_by_row;
    double build_seconds;
};

std::vector<Triangle> triangles_of(const TriangleMesh& mesh,
                                   std::span<const TriangleCorners> corners)
{
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : corners)
        triangles.push_back({{mesh.positions()[a], mesh.positions()[b], mesh.positions()[c]}});
    return triangles;
}

Result<std::unique_ptr<Scene>> make_scene(TriangleMesh mesh)
{
    const double start = processor_seconds();
    auto index = build_mesh_index(mesh, {.execution = {.threads = {1}}});
    if (!index) return tl::unexpected(index.error());
    const double seconds = processor_seconds() - start;
    std::vector<TriangleCorners> sorted;
    for (std::uint32_t row = 0; row < index->triangle_count(); ++row)
        sorted.push_back(mesh.triangles()[to_index(index->ids()[row])]);
    TriangleArrays by_id(triangles_of(mesh, mesh.triangles()));
    TriangleArrays by_row(triangles_of(mesh, sorted));
    VertexArrays vertices_by_id(mesh.positions(), mesh.triangles());
    VertexArrays vertices_by_row(mesh.positions(), sorted);
    return std::make_unique<Scene>(
        Scene{std::move(mesh), *index, std::move(sorted), std::move(by_id), std::move(by_row),
              std::move(vertices_by_id), std::move(vertices_by_row), seconds});
}

std::size_t visible_count(const Scene& scene, const ViewVolume& volume)
{
    std::size_t count = 0;
    visit_visible(scene.index, volume, CullMode::conservative, [&](TriangleRange range) {
        count += range.count;
        return Flow::proceed;
    });
    return count;
}

/// A camera outside of the mesh that sees about `part` of its triangles, by its field of view; for
/// nothing, one that looks past the surface through the mesh's box.
ViewVolume camera_for(const Scene& scene, double part, std::mt19937_64& random)
{
    std::uniform_real_distribution<double> number(-1, 1);
    const Box box = bounding_box(scene.mesh);
    const double radius = 0.5 * box.extent().norm();
    const auto triangles = static_cast<double>(scene.mesh.triangle_count());
    for (;;) {
        const double x = number(random);
        const double y = number(random);
        const Vec3 away = Vec3(x, y, number(random)).normalized();
        PerspectiveCamera camera;
        camera.eye = box.center() + 2.5 * radius * away;
        camera.up = std::abs(away.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
        camera.near = 0.01 * radius;
        camera.far = 10 * radius;
        const auto with = [&](double angle) {
            camera.field_of_view = angle;
            return make_perspective_volume(camera).value();
        };
        if (part == 0) {
            const double a = number(random);
            const double b = number(random);
            const Vec3 target =
                box.center() + 0.45 * Vec3(a, b, number(random)).cwiseProduct(box.extent());
            camera.forward = target - camera.eye;
            ViewVolume volume = with(0.1);
            if (visible_count(scene, volume) == 0) return volume;
            continue;
        }
        const auto some = scene.mesh.triangle(
            TriangleId{static_cast<std::uint32_t>(random() % scene.mesh.triangle_count())});
        camera.forward = (part == 1 ? box.center() : some[0]) - camera.eye;
        if (part == 1) return with(1.5);
        double narrow = 1e-4;
        double wide = 2.5;
        for (int i = 0; i < 40; ++i) {
            const double middle = std::sqrt(narrow * wide);
            const auto count = static_cast<double>(visible_count(scene, with(middle)));
            (count < part * triangles ? narrow : wide) = middle;
        }
        ViewVolume volume = with(wide);
        const auto count = static_cast<double>(visible_count(scene, volume));
        if (count < 1.3 * part * triangles && count > 0.7 * part * triangles) return volume;
    }
}

/// One way to cull, and how long it took.
struct Runner {
    const char* name;
    std::function<std::size_t(const ViewVolume&)> run; ///< returns how much it wrote
    std::vector<double> seconds = {};
};

std::size_t sum_of(std::span<const TriangleRange> ranges)
{
    std::size_t sum = 0;
    for (const TriangleRange& range : ranges) sum += range.count;
    return sum;
}

void race(Scene& scene, double part, const BenchOptions& options)
{
    std::mt19937_64 random(options.seed);
    std::vector<ViewVolume> volumes;
    volumes.reserve(static_cast<std::size_t>(options.views));
    for (int i = 0; i < options.views; ++i) volumes.push_back(camera_for(scene, part, random));
    std::vector<std::vector<LanePlane>> planes;
    planes.reserve(volumes.size());
    for (const ViewVolume& volume : volumes) planes.push_back(lane_planes(volume));

    const std::size_t triangles = scene.mesh.triangle_count();
    std::vector<TriangleRange> ranges(triangles / 2 + 1);
    std::vector<TriangleRange> lane_ranges(triangles / 2 + 1);
    std::vector<std::uint32_t> lane_ids(triangles + 16);
    std::vector<TriangleId> ids;
    std::size_t at = 0;
    std::vector<Runner> runners = {
        {"ranges", [&](const ViewVolume& v) { return visible_ranges(scene.index, v, ranges); }},
        {"  triangles",
         [&](const ViewVolume& /*v*/) {
             return scene.by_row.visible_ranges(planes[at], lane_ranges);
         }},
        {"  vertices",
         [&](const ViewVolume& /*v*/) {
             return scene.vertices_by_row.visible_ranges(planes[at], lane_ranges);
         }},
        {"exact ranges",
         [&](const ViewVolume& v) {
             return visible_ranges(scene.index, v, ranges, CullMode::exact);
         }},
        {"ids",
         [&](const ViewVolume& v) {
             visible_triangles(scene.index, v, CullMode::conservative, ids);
             return ids.size();
         }},
        {"  triangles",
         [&](const ViewVolume& /*v*/) { return scene.by_id.visible_ids(planes[at], lane_ids); }},
        {"  vertices", [&](const ViewVolume& /*v*/) {
             return scene.vertices_by_id.visible_ids(planes[at], lane_ids);
         }}};

    // Once for the answers, which also warms up.
    std::size_t seen = 0;
    std::size_t range_count = 0;
    std::size_t exact = 0;
    std::size_t different = 0;
    for (at = 0; at < volumes.size(); ++at) {
        const std::size_t count = visible_ranges(scene.index, volumes[at], ranges);
        const std::size_t own = sum_of(std::span(ranges).first(count));
        seen += own;
        range_count += count;
        visible_triangles(scene.index, volumes[at], CullMode::conservative, ids);
        if (ids.size() != own) std::printf("  RANGES AND IDS DIFFER\n");
        for (const bool by_vertices : {false, true}) {
            const std::size_t others = by_vertices
                                           ? scene.vertices_by_id.visible_ids(planes[at], lane_ids)
                                           : scene.by_id.visible_ids(planes[at], lane_ids);
            std::vector<TriangleId> lanes;
            for (std::size_t i = 0; i < others; ++i) lanes.push_back(TriangleId{lane_ids[i]});
            std::vector<TriangleId> only;
            std::ranges::set_symmetric_difference(ids, lanes, std::back_inserter(only));
            different += only.size();
            const std::size_t runs =
                by_vertices ? scene.vertices_by_row.visible_ranges(planes[at], lane_ranges)
                            : scene.by_row.visible_ranges(planes[at], lane_ranges);
            if (sum_of(std::span(lane_ranges).first(runs)) != others)
                std::printf("  RANGES AND IDS OF LANES DIFFER\n");
        }
        const std::size_t exact_count =
            visible_ranges(scene.index, volumes[at], ranges, CullMode::exact);
        exact += sum_of(std::span(ranges).first(exact_count));
    }
    for (int round = 0; round < options.rounds; ++round) {
        for (Runner& runner : runners) {
            double seconds = 0;
            for (at = 0; at < volumes.size(); ++at) {
                const double start = processor_seconds();
                (void)runner.run(volumes[at]);
                seconds += processor_seconds() - start;
            }
            runner.seconds.push_back(seconds / static_cast<double>(volumes.size()));
        }
    }
    const auto views = static_cast<double>(volumes.size());
    std::printf("  %8.3f %% visible, %9.1f ranges, exact %9.1f fewer, lanes differ in %zu\n",
                100 * static_cast<double>(seen) / views / static_cast<double>(triangles),
                static_cast<double>(range_count) / views, static_cast<double>(seen - exact) / views,
                different);
    double own = 0;
    for (const Runner& runner : runners) {
        const double time = median(runner.seconds);
        if (runner.name[0] != ' ') {
            own = time;
            std::printf("    %-13s %10.2f us\n", runner.name, 1e6 * time);
        } else {
            std::printf("    %-13s %10.2f us  (%7.2f x)\n", runner.name, 1e6 * time, time / own);
        }
    }
}

/// Frames of a camera that turns about the mesh by so many degrees each, and sees about a tenth.
std::vector<ViewVolume> path_about(const Scene& scene, double degrees, std::size_t count)
{
    const Box box = bounding_box(scene.mesh);
    const double radius = 0.5 * box.extent().norm();
    const auto triangles = static_cast<double>(scene.mesh.triangle_count());
    const auto frame = [&](double angle, double field_of_view) {
        PerspectiveCamera camera;
        const Vec3 away = Vec3(std::cos(angle), std::sin(angle), 0.3).normalized();
        camera.eye = box.center() + 2.5 * radius * away;
        camera.forward = box.center() + Vec3(0, 0, 0.1 * radius) - camera.eye;
        camera.up = Vec3::UnitZ();
        camera.near = 0.01 * radius;
        camera.far = 10 * radius;
        camera.field_of_view = field_of_view;
        return make_perspective_volume(camera).value();
    };
    double narrow = 1e-4;
    double wide = 2.5;
    for (int i = 0; i < 40; ++i) {
        const double middle = std::sqrt(narrow * wide);
        const auto seen = static_cast<double>(visible_count(scene, frame(0, middle)));
        (seen < 0.1 * triangles ? narrow : wide) = middle;
    }
    std::vector<ViewVolume> frames;
    constexpr double radians = 3.14159265358979 / 180;
    for (std::size_t i = 0; i < count; ++i)
        frames.push_back(frame(static_cast<double>(i) * degrees * radians, wide));
    return frames;
}

/// Culls along smooth paths, in order and shuffled, and counts what a front could spare.
void race_along_paths(const Scene& scene, const BenchOptions& options)
{
    constexpr std::size_t count = 64;
    std::vector<TriangleRange> ranges(scene.mesh.triangle_count() / 2 + 1);
    std::printf(
        "  along a path, 10 %% visible; blocks looked at a frame, and with a front kept for "
        "2, 4, 8, 16, 32 frames\n");
    for (const double degrees : {0.001, 0.01, 0.1, 1.0}) {
        const std::vector<ViewVolume> frames = path_about(scene, degrees, count);
        std::vector<std::size_t> order(count);
        for (std::size_t i = 0; i < count; ++i) order[i] = i;
        std::vector<std::size_t> shuffled = order;
        std::mt19937_64 random(options.seed);
        std::ranges::shuffle(shuffled, random);
        const auto time = [&](const std::vector<std::size_t>& places) {
            const double start = processor_seconds();
            for (const std::size_t i : places) (void)visible_ranges(scene.index, frames[i], ranges);
            return (processor_seconds() - start) / static_cast<double>(count);
        };
        std::vector<double> along;
        std::vector<double> across;
        for (int round = 0; round < options.rounds; ++round) {
            along.push_back(time(order));
            across.push_back(time(shuffled));
        }
        const PathCounts counts = count_path(scene.index, frames);
        std::printf("    %5.3f degrees %8.2f us, shuffled %8.2f us; %7.1f nodes + %7.1f leaves, "
                    "%5.1f %% of them as before; front",
                    degrees, 1e6 * median(along), 1e6 * median(across), counts.plain_nodes,
                    counts.plain_leaves, 100 * counts.kept_leaves);
        for (const double blocks : counts.with_front) std::printf(" %8.1f", blocks);
        std::printf("\n");
    }
}

int run_mesh(const std::string& name, const BenchOptions& options)
{
    auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    const auto scene = make_scene(std::move(*mesh));
    if (!scene) {
        std::fprintf(stderr, "%s: %s\n", name.c_str(), describe(scene.error()).c_str());
        return 1;
    }
    std::printf("%s: %zu triangles, index built in %.3f s, %.1f bytes per triangle\n",
                std::filesystem::path(name).filename().string().c_str(),
                (*scene)->mesh.triangle_count(), (*scene)->build_seconds,
                static_cast<double>((*scene)->index.bytes()) /
                    static_cast<double>((*scene)->mesh.triangle_count()));
    for (const double part : {0.0, 0.001, 0.1, 0.5, 1.0}) race(**scene, part, options);
    race_along_paths(**scene, options);
    (void)std::fflush(stdout);
    return 0;
}

int run(const BenchOptions& options)
{
    std::printf("one thread, %d cameras from seed %llu, medians of %d interleaved rounds; per "
                "camera, lanes over ours\n",
                options.views, static_cast<unsigned long long>(options.seed), options.rounds);
    for (const std::string& name : meshes_of(options))
        if (const int status = run_mesh(name, options); status != 0) return status;
    return 0;
}

} // namespace
} // namespace proxima::bench

int main(int argc, char** argv)
{
    proxima::bench::BenchOptions options;
    return proxima::bench::run_program(
        argc, argv, "View-volume culling, ours beside brute force by vector lanes",
        [&](CLI::App& app) {
            app.add_option("--views", options.views, "Cameras of each part")
                ->check(CLI::Range(1, 1000));
            add_common_options(app, options);
        },
        [&] { return proxima::bench::run(options); });
}
