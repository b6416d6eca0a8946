#include "touch_patch_table.h"

#include "cli/patch_speeds.h"
#include "touch_model.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace proxima::bench {

namespace {

constexpr std::array speeds = {0.1, 0.25, 0.5, 1.0}; // m/s
constexpr std::array depths = {1, 2, 3};             // rings

} // namespace

int run_patch_table(const std::string& mesh, const PatchTableOptions& options)
{
    auto loaded = load_touch_model(mesh, options.keep);
    if (!loaded) {
        std::printf("%s: %s\n", mesh.c_str(), describe(loaded.error()).c_str());
        return 1;
    }
    const WorkspaceMap map = (*loaded)->map;
    proxima::TouchModel model;
    model.surface = {std::move((*loaded)->mesh), std::move((*loaded)->topology)};
    model.index = (*loaded)->index;
    model.contact = std::make_unique<IndexContactSurface>(model.index);
    std::printf(
        "%s, %zu triangles: patches at 100 Hz, a period late, in %llu ticks of each script\n",
        mesh.c_str(), model.surface.mesh.triangle_count(),
        static_cast<unsigned long long>(options.ticks));
    std::printf("%-6s %-9s %8s %10s %8s %10s %8s %9s %9s %9s %8s %8s %8s %8s\n", "m/s", "patch",
                "patches", "triangles", "largest", "sent down", "touching", "missed", "apart",
                "cut off", "lost", "p50 us", "p99.9", "max");
    for (const double speed : speeds) {
        for (const int rings : depths) {
            const PatchAccount sum =
                touch_at_speed(model, map, {.rings = rings},
                               {.speed = speed, .ticks = options.ticks, .radius = options.radius});
            const auto microseconds = [&](double part) {
                return 1e-3 * static_cast<double>(sum.tick.quantile(part));
            };
            const double patches = std::max(1.0, static_cast<double>(sum.patches));
            const double mean = static_cast<double>(sum.triangles) / patches;
            const double touching = std::max(1.0, static_cast<double>(sum.touching_ticks));
            std::printf("%-6g %-9s %8llu %10.1f %8llu %9.3f%% %8llu %8.3f%% %8.3f%% %9llu %8llu "
                        "%8.2f %8.2f "
                        "%8.2f\n",
                        speed, name_of(sum.settings).c_str(),
                        static_cast<unsigned long long>(sum.patches), mean,
                        static_cast<unsigned long long>(sum.largest),
                        100 * mean / static_cast<double>(sum.model_triangles),
                        static_cast<unsigned long long>(sum.touching_ticks),
                        100 * static_cast<double>(sum.missed_ticks) / touching,
                        100 * static_cast<double>(sum.apart_ticks) / touching,
                        static_cast<unsigned long long>(sum.incomplete),
                        static_cast<unsigned long long>(sum.lost_ticks), microseconds(0.5),
                        microseconds(0.999), microseconds(1));
            (void)std::fflush(stdout);
        }
    }
    std::printf("\n");
    return 0;
}

} // namespace proxima::bench
