// Chapters 4 and 5: how long queries take by the thesis's structures, beside the mesh index.
#include "base/progress.h"
#include "base/text.h"
#include "cli/stopwatch.h"
#include "cli/text_table.h"
#include "cli/thesis_comparison.h"
#include "lab/query_sets.h"
#include "proxima/cast_ray.h"
#include "proxima/cull.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "proxima/thesis.h"
#include "thesis/proximity_octree/thesis_closest.h"

#include <algorithm>
#include <array>
#include <fmt/core.h>
#include <numbers>
#include <string>
#include <vector>

namespace proxima {

namespace {

constexpr const char* sphere_name = "sphere:100x100"; ///< convex, as closest features want it
constexpr std::size_t query_count = 20'000;
constexpr std::size_t frame_count = 100; ///< of culling and of contact
constexpr std::size_t rounds = 5;

/// What one structure took.
struct StructureTime {
    double build_seconds = 0;
    std::uint64_t bytes = 0;
    double nanoseconds = 0; ///< of a query: the median of the rounds
};

/// Ends soon, with no time, where somebody asks to stop.
template <class Ask>
double median_nanoseconds(std::size_t queries, const Progress* progress, const Ask& ask)
{
    std::array<double, rounds> times{};
    for (double& time : times) {
        const Stopwatch watch;
        for (std::size_t i = 0; i < queries; ++i) {
            if (is_cancelled(progress)) return 0;
            ask(i);
        }
        time = 1e9 * watch.seconds() / static_cast<double>(queries);
    }
    std::ranges::sort(times);
    return times[rounds / 2];
}

/// The models of all rows, and how long building them took.
struct Structures {
    TriangleMesh mesh;
    Topology topology;
    Octree octree;
    MeshIndex index;
    ThesisProximityOctree thesis_lists;
    double octree_seconds = 0;
    double index_seconds = 0;
    double thesis_list_seconds = 0;
};

Result<Structures> build(const ThesisComparisonOptions& options)
{
    const Threads threads = options.threads_to_measure;
    auto mesh = sample_mesh(sphere_name);
    if (!mesh) return tl::unexpected(mesh.error());
    auto topology = build_topology(*mesh, {.execution = {.threads = threads}});
    if (!topology) return tl::unexpected(topology.error());
    Stopwatch octree_watch;
    auto octree = build_octree(
        *mesh, {.classification = Classification::none, .execution = {.threads = threads}});
    if (!octree) return tl::unexpected(octree.error());
    const double octree_seconds = octree_watch.seconds();
    const Stopwatch index_watch;
    auto index = build_mesh_index(*mesh, {.execution = {.threads = threads}});
    if (!index) return tl::unexpected(index.error());
    const double index_seconds = index_watch.seconds();
    const Stopwatch thesis_watch;
    auto thesis_lists = build_thesis_proximity_octree(
        *mesh, *topology,
        {.execution = {.threads = threads, .progress = options.execution.progress}});
    if (!thesis_lists) return tl::unexpected(thesis_lists.error());
    const double thesis_list_seconds = thesis_watch.seconds();
    return Structures{std::move(*mesh), std::move(*topology),     std::move(*octree),
                      *index,           std::move(*thesis_lists), octree_seconds,
                      index_seconds,    thesis_list_seconds};
}

class QueryTable {
public:
    explicit QueryTable(ThesisComparison& result) : result_(result) {}

    /// `agree`: whether both gave the answers that they should.
    void add(const std::string& query, const StructureTime& thesis, const StructureTime& index,
             bool agree)
    {
        const auto megabytes = [](std::uint64_t bytes) {
            return fmt::format("{:.2f}", 1e-6 * static_cast<double>(bytes));
        };
        table_.add_row({query, fmt::format("{:.3f}", thesis.build_seconds), megabytes(thesis.bytes),
                        fmt::format("{:.0f}", thesis.nanoseconds),
                        fmt::format("{:.3f}", index.build_seconds), megabytes(index.bytes),
                        fmt::format("{:.0f}", index.nanoseconds),
                        fmt::format("{:.2f}", thesis.nanoseconds / index.nanoseconds),
                        agree ? "agree" : "DIFFER"});
        const auto json = [](const StructureTime& time) {
            return nlohmann::ordered_json{{"build_seconds", time.build_seconds},
                                          {"bytes", time.bytes},
                                          {"ns_per_query", time.nanoseconds}};
        };
        result_.rows.push_back(
            {{"query", query}, {"thesis", json(thesis)}, {"index", json(index)}, {"agree", agree}});
    }
    [[nodiscard]] std::string text() const { return table_.text(); }

private:
    ThesisComparison& result_;
    TextTable table_{{"Query", "Thesis build s", "MB", "ns", "Index build s", "MB", "ns",
                      "Thesis / index", "Answers"}};
};

void add_closest(const Structures& of, const Progress* progress, QueryTable& table)
{
    for (const QuerySet& set : query_sets(of.mesh, query_count, 1)) {
        std::vector<Vec3> points;
        bool agree = true;
        for (const Vec3& point : set.points) {
            if (is_cancelled(progress)) return;
            const auto found = closest_feature(of.thesis_lists, of.mesh, of.topology, point);
            if (!found) continue; // inside, or outside the root
            points.push_back(point);
            const double distance = closest_feature(of.index, point)->squared_distance;
            agree = agree && std::abs(found->squared_distance - distance) <= 1e-12;
        }
        if (points.empty()) continue;
        double sum = 0;
        const StructureTime thesis{of.thesis_list_seconds, of.thesis_lists.bytes(),
                                   median_nanoseconds(points.size(), progress, [&](std::size_t i) {
                                       sum += closest_feature(of.thesis_lists, of.mesh, of.topology,
                                                              points[i])
                                                  ->squared_distance;
                                   })};
        const StructureTime index{of.index_seconds, of.index.bytes(),
                                  median_nanoseconds(points.size(), progress, [&](std::size_t i) {
                                      sum -= closest_feature(of.index, points[i])->squared_distance;
                                  })};
        table.add(
            fmt::format("closest feature, set {} ({} points outside)", set.name, points.size()),
            thesis, index, agree && std::isfinite(sum));
    }
}

void add_rays(const Structures& of, const Progress* progress, QueryTable& table)
{
    const auto sets = query_sets(of.mesh, 2 * query_count, 2);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < query_count; ++i) {
        const Vec3 origin = 3 * sets[0].points[2 * i];
        rays.push_back({.origin = origin, .direction = sets[0].points[2 * i + 1] - origin});
    }
    bool agree = true;
    for (const Ray& ray : rays) {
        if (is_cancelled(progress)) return;
        agree =
            agree && closest_hit_by_cells(of.octree, of.mesh, ray) == closest_hit(of.index, ray);
    }
    std::size_t hits = 0;
    const double thesis = median_nanoseconds(rays.size(), progress, [&](std::size_t i) {
        hits += closest_hit_by_cells(of.octree, of.mesh, rays[i]) ? 1U : 0U;
    });
    const double index = median_nanoseconds(rays.size(), progress, [&](std::size_t i) {
        hits += closest_hit(of.index, rays[i]) ? 1U : 0U;
    });
    table.add(fmt::format("first hit of a ray ({} of {} hit)", hits / (2 * rounds), rays.size()),
              {of.octree_seconds, of.octree.bytes(), thesis},
              {of.index_seconds, of.index.bytes(), index}, agree);
}

void add_culling(const Structures& of, const Progress* progress, QueryTable& table)
{
    std::vector<ViewVolume> volumes;
    for (std::size_t i = 0; i < frame_count; ++i) {
        const double turn = 2 * std::numbers::pi * static_cast<double>(i) / frame_count;
        const Vec3 eye(1.5 * std::cos(turn), 1.5 * std::sin(turn), 0.5);
        const Vec3 forward(-std::cos(turn + 0.5), -std::sin(turn + 0.5), -0.3);
        auto volume = make_perspective_volume({.eye = eye, .forward = forward, .near = 0.01});
        if (volume) volumes.push_back(std::move(*volume));
    }
    bool agree = true;
    std::size_t listed = 0;
    std::size_t visible = 0;
    std::vector<TriangleId> ids;
    for (const ViewVolume& volume : volumes) {
        if (is_cancelled(progress)) return;
        const CellCulling culled = cull_by_cells(of.octree, volume);
        visible_triangles(of.index, volume, CullMode::exact, ids);
        agree = agree && std::ranges::includes(culled.triangles, ids);
        listed += culled.triangles.size();
        visible += ids.size();
    }
    const double thesis = median_nanoseconds(volumes.size(), progress, [&](std::size_t i) {
        (void)cull_by_cells(of.octree, volumes[i]);
    });
    const double index = median_nanoseconds(volumes.size(), progress, [&](std::size_t i) {
        visible_triangles(of.index, volumes[i], CullMode::exact, ids);
    });
    table.add(fmt::format("view volume ({} triangles listed, {} visible on average)",
                          listed / volumes.size(), visible / volumes.size()),
              {of.octree_seconds, of.octree.bytes(), thesis},
              {of.index_seconds, of.index.bytes(), index}, agree);
}

void add_contact(const Structures& of, const Progress* progress, QueryTable& table)
{
    std::vector<RigidTransform> poses(frame_count);
    for (std::size_t i = 0; i < frame_count; ++i) {
        const double part = static_cast<double>(i) / frame_count;
        poses[i].translation = Vec3(1.7 + 0.35 * part, 0.1 * part, 0.05);
    }
    bool agree = true;
    std::size_t pairs = 0;
    for (const RigidTransform& pose : poses) {
        if (is_cancelled(progress)) return;
        const auto found = intersect_by_cells({of.mesh, of.octree}, {of.mesh, of.octree}, pose);
        agree = agree && found.pairs == intersecting_pairs(of.index, of.index, pose);
        pairs += found.pairs.size();
    }
    const double thesis = median_nanoseconds(poses.size(), progress, [&](std::size_t i) {
        (void)intersect_by_cells({of.mesh, of.octree}, {of.mesh, of.octree}, poses[i]);
    });
    const double index = median_nanoseconds(poses.size(), progress, [&](std::size_t i) {
        (void)intersecting_pairs(of.index, of.index, poses[i]);
    });
    table.add(fmt::format("two spheres ({} pairs on average)", pairs / poses.size()),
              {of.octree_seconds, of.octree.bytes(), thesis},
              {of.index_seconds, of.index.bytes(), index}, agree);
}

} // namespace

Result<ThesisComparison> compare_queries(const ThesisComparisonOptions& options)
{
    const auto structures = build(options);
    if (!structures) return tl::unexpected(structures.error());
    ThesisComparison result;
    QueryTable table(result);
    for (const auto add : {add_closest, add_rays, add_culling, add_contact}) {
        add(*structures, options.execution.progress, table);
        if (is_cancelled(options.execution.progress)) return cancelled("the table");
    }
    result.text = fmt::format("{}, {} triangles, octrees of depth 5 and threshold 1; one thread, "
                              "medians of {} rounds\n\n{}\n",
                              sphere_name, structures->mesh.triangle_count(), rounds, table.text());
    result.notes = {
        "The thesis has no times for these queries (chapter 6: no temporal measurements have been "
        "conducted).",
        "Thesis: its proximity octree; cells along the ray; triangles that visible cells list; "
        "double recursion of two octrees. Index: the mesh index, without lists.",
        "Agree: equal distances to 1e-12 (squared), equal hits, the visible triangles among those "
        "listed, equal pairs."};
    return result;
}

} // namespace proxima
