#include "touch_curve.h"

#include "cli/plot.h"
#include "touch_table.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

namespace proxima::bench {

namespace {

constexpr std::array toruses = {"torus:32x16", "torus:64x32", "torus:128x64", "torus:256x128"};

struct CurvePoint {
    std::string name;
    bool is_torus = false;
    std::size_t triangles = 0;
    double p50 = 0; ///< us
    double p99_99 = 0;
    double peer_p50 = 0;
    double peer_p99_99 = 0;
};

Result<CurvePoint> time_mesh(const std::string& name, const TouchRaceOptions& options)
{
    const auto model = load_touch_model(name, options.keep);
    if (!model) return tl::unexpected(model.error());
    const BoxTree tree((*model)->mesh);
    TickSums ours;
    TickSums peer;
    for (const char* const script : touch_scripts) {
        const TouchTrack track = record_track(**model, script, options.ticks, options.radius);
        add_track(
            ours, track,
            time_track(*(*model)->surface, (*model)->map, track, options.radius, options.replays));
        add_track(peer, track, time_track(tree, **model, track, options.replays));
    }
    CurvePoint point;
    point.name = std::filesystem::path(name).filename().string();
    point.is_torus = name.starts_with("torus");
    point.triangles = (*model)->mesh.triangle_count();
    point.p50 = ours.back().times.microseconds(0.5);
    point.p99_99 = ours.back().times.microseconds(0.9999);
    point.peer_p50 = peer.back().times.microseconds(0.5);
    point.peer_p99_99 = peer.back().times.microseconds(0.9999);
    return point;
}

std::string csv_of(const std::vector<CurvePoint>& points)
{
    std::string csv = "mesh,triangles,p50_us,p99_99_us,box_tree_p50_us,box_tree_p99_99_us\n";
    for (const CurvePoint& point : points) {
        std::array<char, 256> line{};
        (void)std::snprintf(line.data(), line.size(), "%s,%zu,%.3f,%.3f,%.3f,%.3f\n",
                            point.name.c_str(), point.triangles, point.p50, point.p99_99,
                            point.peer_p50, point.peer_p99_99);
        csv += line.data();
    }
    return csv;
}

Figure figure_of(const std::vector<CurvePoint>& points, const TouchRaceOptions& options)
{
    std::vector<PlotSeries> series;
    const auto add = [&](const std::string& name, bool torus, double CurvePoint::*time) {
        PlotSeries one{name, {}};
        for (const CurvePoint& point : points) {
            if (point.is_torus == torus)
                one.points.emplace_back(static_cast<double>(point.triangles), point.*time);
        }
        if (!one.points.empty()) series.push_back(std::move(one));
    };
    add("scans p99.99", false, &CurvePoint::p99_99);
    add("scans p50", false, &CurvePoint::p50);
    add("boxes p50", false, &CurvePoint::peer_p50);
    add("torus p99.99", true, &CurvePoint::p99_99);
    add("torus p50", true, &CurvePoint::p50);
    const std::string note = std::to_string(options.ticks) +
                             " of each of six scripts, the least of " +
                             std::to_string(options.replays) + " replays";
    return log_plot(series, {"A servo tick by the size of the model",
                             {"computed work in direct mode, a point with friction", note,
                              "boxes: a god-object without friction over a tree of boxes"},
                             "triangles",
                             "microseconds per tick"});
}

} // namespace

int run_curve(const std::vector<std::string>& meshes, const TouchRaceOptions& options,
              const std::vector<std::string>& files)
{
    for (const std::string& file : files) {
        if (const Status status = check_plot_format(file); !status) {
            std::printf("%s\n", describe(status.error()).c_str());
            return 2;
        }
    }
    std::vector<std::string> names(toruses.begin(), toruses.end());
    names.insert(names.end(), meshes.begin(), meshes.end());
    std::vector<CurvePoint> points;
    std::printf("%-30s %10s %9s %9s %9s %9s\n", "mesh", "triangles", "p50 us", "p99.99",
                "boxes p50", "p99.99");
    for (const std::string& name : names) {
        auto point = time_mesh(name, options);
        if (!point) {
            std::printf("%s: %s\n", name.c_str(), describe(point.error()).c_str());
            return 1;
        }
        std::printf("%-30s %10zu %9.2f %9.2f %9.2f %9.2f\n", point->name.c_str(), point->triangles,
                    point->p50, point->p99_99, point->peer_p50, point->peer_p99_99);
        (void)std::fflush(stdout);
        points.push_back(std::move(*point));
    }
    std::ranges::stable_sort(points, {}, &CurvePoint::triangles);
    const std::string csv = csv_of(points);
    const Figure figure = figure_of(points, options);
    for (const std::string& file : files) {
        if (const Status status = write_plot(csv, figure, file); !status) {
            std::printf("%s\n", describe(status.error()).c_str());
            return 1;
        }
        std::printf("wrote %s\n", file.c_str());
    }
    return 0;
}

} // namespace proxima::bench
