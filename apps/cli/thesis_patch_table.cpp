// Section 5.1: which adjacency depth suffices at which speed of the hand.
#include "base/progress.h"
#include "base/text.h"
#include "cli/patch_speeds.h"
#include "cli/text_table.h"
#include "cli/thesis_comparison.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <array>
#include <fmt/core.h>
#include <memory>

namespace proxima {

namespace {

constexpr std::array speeds = {0.05, 0.1, 0.25, 0.5, 1.0};       // m/s
constexpr std::array depths = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24}; // rings
constexpr std::array<std::string_view, 3> spheres = {"sphere:50x50", "sphere:100x100",
                                                     "icosphere:5"};

Result<std::unique_ptr<TouchModel>> make_model(std::string_view name,
                                               const ThesisComparisonOptions& options)
{
    auto model = std::make_unique<TouchModel>();
    auto mesh = sample_mesh(std::string(name));
    if (!mesh) return tl::unexpected(mesh.error());
    model->surface.mesh = std::move(*mesh);
    auto topology =
        build_topology(model->surface.mesh, {.execution = {.threads = options.execution.threads}});
    if (!topology) return tl::unexpected(topology.error());
    model->surface.topology = std::move(*topology);
    auto index = build_mesh_index(model->surface.mesh, {.execution = options.execution});
    if (!index) return tl::unexpected(index.error());
    model->index = *index;
    auto thesis = build_thesis_proximity_octree(model->surface.mesh, model->surface.topology,
                                                {.execution = options.execution});
    if (!thesis) return tl::unexpected(thesis.error());
    model->thesis = std::move(*thesis);
    auto contact = IndexContactSurface::make(model->index);
    if (!contact) return tl::unexpected(contact.error());
    model->contact = std::move(*contact);
    return model;
}

double percent_of(std::uint64_t part, std::uint64_t all)
{
    return all == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(all);
}

double triangles_sent(const PatchAccount& account)
{
    return account.patches == 0
               ? 0
               : static_cast<double>(account.triangles) / static_cast<double>(account.patches);
}

/// Tries depths until nothing is missed, and adds a row for each.
Status add_speed(std::string_view name, const TouchModel& model, double speed,
                 const ThesisComparisonOptions& options, TextTable& table, ThesisComparison& result)
{
    const WorkspaceMap map =
        fit_workspace(bounding_box(model.surface.mesh), find_device("omni")->workspace_radius);
    for (const int depth : depths) {
        if (is_cancelled(options.execution.progress)) return cancelled("the table");
        const PatchAccount account = touch_at_speed(
            model, map, {.rings = depth, .method = QueryMethod::thesis}, {.speed = speed});
        const bool suffices = account.missed_ticks == 0 && account.incomplete == 0;
        table.add_row(
            {std::string(name), fmt::format("{:g}", speed), to_text(depth),
             fmt::format("{:.1f}", triangles_sent(account)),
             fmt::format("{:.2f}", percent_of(account.missed_ticks, account.touching_ticks)),
             fmt::format("{:.2f}", percent_of(account.apart_ticks, account.touching_ticks)),
             suffices ? "suffices" : ""});
        result.rows.push_back({{"model", name},
                               {"speed", speed},
                               {"adjacency_depth", depth},
                               {"mean_triangles", triangles_sent(account)},
                               {"touching_ticks", account.touching_ticks},
                               {"missed_ticks", account.missed_ticks},
                               {"apart_ticks", account.apart_ticks},
                               {"suffices", suffices}});
        if (suffices) break;
    }
    return {};
}

} // namespace

Result<ThesisComparison> compare_adjacency_depths(const ThesisComparisonOptions& options)
{
    TextTable table({"Model", "Hand m/s", "Adjacency depth", "Triangles sent", "Missed %",
                     "Proxy apart %", ""});
    ThesisComparison result;
    for (const std::string_view name : spheres) {
        const auto model = make_model(name, options);
        if (!model) return tl::unexpected(model.error());
        for (const double speed : speeds) {
            if (Status status = add_speed(name, **model, speed, options, table, result); !status)
                return tl::unexpected(status.error());
        }
    }
    result.text = fmt::format(
        "Patches at 100 Hz, each used from 10 ms to 20 ms after its device position was read; the "
        "model\nfills the workspace of a Phantom Omni; {} scripts of one second at 1,000 "
        "Hz\n\n{}\n",
        patch_scripts.size(), table.text());
    result.notes = {
        "Missed: touching ticks in which a proxy on the whole model rests on a triangle that the "
        "patch lacks. Apart: the proxy on the patch stands elsewhere by more than a micrometre.",
        "The thesis gives no numbers: it adjusts the adjacency depth by hand. A depth suffices "
        "only "
        "for triangles of one size and hands below one speed: small triangles, such as those at a "
        "sphere's poles, need more rings for the same distance."};
    return result;
}

} // namespace proxima
