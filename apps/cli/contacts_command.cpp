// proxima contacts: where two closed meshes overlap, in which direction, and how deep.
#include "base/text.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/json_numbers.h"
#include "cli/model_options.h"
#include "cli/poses.h"
#include "cli/stopwatch.h"
#include "proxima/contacts.h"
#include "proxima/mesh_index.h"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

struct ContactsOptions {
    std::string model_a;
    std::string model_b;
    std::string poses;
    PenetrationOptions search;
};

Result<Solid> load_solid(const std::string& model, Session& session)
{
    auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    const auto index = index_of_model(model, *mesh, session);
    if (!index) return tl::unexpected(index.error());
    auto solid = build_solid(*index, {.execution = session.execution()});
    if (!solid) return at_model(solid.error(), model);
    return solid;
}

std::string_view name_of(PenetrationMethod method)
{
    return method == PenetrationMethod::apart    ? "apart"
           : method == PenetrationMethod::convex ? "convex"
                                                 : "bounds";
}

std::string triple_text(const Vec3& p)
{
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x() + 0.0, p.y() + 0.0, p.z() + 0.0);
}

Json json_of(const ContactRegions& found)
{
    Json regions = Json::array();
    for (const ContactRegion& region : found.regions) {
        Json points = Json::array();
        for (const RegionPoint& point : region.contacts()) {
            points.push_back({{"on_a", json_numbers(point.on_a)},
                              {"on_b", json_numbers(point.on_b)},
                              {"depth", point.depth}});
        }
        regions.push_back({{"position", json_numbers(region.position)},
                           {"normal", json_numbers(region.normal)},
                           {"depth", region.depth},
                           {"length", region.length},
                           {"area", region.area},
                           {"lines", region.line_count},
                           {"points", points}});
    }
    return regions;
}

struct PoseContacts {
    PenetrationDepth depth;
    ContactRegions regions;
    double depth_seconds = 0;
    double region_seconds = 0;
};

Json json_of(const PoseContacts& found)
{
    return {{"method", name_of(found.depth.method)},
            {"lower", found.depth.lower},
            {"upper", found.depth.upper},
            {"direction", json_numbers(found.depth.direction)},
            {"translation", json_numbers(found.depth.translation)},
            {"deepest", json_numbers(found.depth.deepest)},
            {"depth_seconds", found.depth_seconds},
            {"regions", json_of(found.regions)},
            {"region_seconds", found.region_seconds}};
}

std::string text_of(const PoseContacts& found)
{
    const PenetrationDepth& depth = found.depth;
    if (depth.method == PenetrationMethod::apart) return "apart\n";
    std::string text =
        fmt::format("penetration depth {:.9g} to {:.9g} ({}), free along {}, {:.3f} ms\n",
                    depth.lower, depth.upper, name_of(depth.method), triple_text(depth.direction),
                    1e3 * found.depth_seconds);
    text += fmt::format("  {} contact region{}, {:.3f} ms\n", found.regions.regions.size(),
                        found.regions.regions.size() == 1 ? "" : "s", 1e3 * found.region_seconds);
    constexpr std::size_t shown = 10;
    for (std::size_t i = 0; i < std::min(shown, found.regions.regions.size()); ++i) {
        const ContactRegion& region = found.regions.regions[i];
        text += fmt::format(
            "  region {}: at {}, normal {}, depth {:.6g}, contour {:.6g} long, {} point{}\n", i,
            triple_text(region.position), triple_text(region.normal), region.depth, region.length,
            region.point_count, region.point_count == 1 ? "" : "s");
    }
    if (found.regions.regions.size() > shown) text += "  ...\n";
    return text;
}

Status run_contacts(const ContactsOptions& options, Session& session)
{
    if (Status status = session.check_outputs({}); !status) return status;
    Poses read{.poses = std::vector<RigidTransform>(1)};
    if (!options.poses.empty()) {
        auto table = read_poses(options.poses, session);
        if (!table) return tl::unexpected(table.error());
        read = std::move(*table);
    }
    const Stopwatch build_watch;
    const auto a = load_solid(options.model_a, session);
    if (!a) return tl::unexpected(a.error());
    const auto b = load_solid(options.model_b, session);
    if (!b) return tl::unexpected(b.error());
    const double build_seconds = build_watch.seconds();
    const auto kind = [](const Solid& solid) {
        return solid.is_convex() ? "convex" : "not convex";
    };
    std::string text =
        fmt::format("A {}: {} triangles, {}\nB {}: {} triangles, {}\nloaded and built "
                    "in {:.3f} s\n",
                    options.model_a, a->index().triangle_count(), kind(*a), options.model_b,
                    b->index().triangle_count(), kind(*b), build_seconds);
    constexpr std::size_t shown_poses = 10;
    Json rows = Json::array();
    {
        const ProgressBar shown(session.progress(), session.bar());
        for (std::size_t i = 0; i < read.poses.size(); ++i) {
            if (Status status = session.check_running(); !status) return status;
            PoseContacts found;
            const Stopwatch depth_watch;
            PenetrationOptions search = options.search;
            search.execution = session.execution();
            const auto depth = penetration_depth(*a, *b, read.poses[i], search);
            if (!depth) return tl::unexpected(depth.error());
            found.depth = *depth;
            found.depth_seconds = depth_watch.seconds();
            const Stopwatch region_watch;
            auto regions =
                contact_regions(*a, *b, read.poses[i], {.execution = session.execution()});
            if (!regions) return tl::unexpected(regions.error());
            found.regions = std::move(*regions);
            found.region_seconds = region_watch.seconds();
            rows.push_back(json_of(found));
            if (i < shown_poses) text += fmt::format("pose {}: {}", i, text_of(found));
        }
    }
    if (read.poses.size() > shown_poses) text += "...\n";
    text += rotation_text(read.rotation_error, true, session);
    session.print(text);
    return session.write_json({{"a", options.model_a},
                               {"b", options.model_b},
                               {"triangles_a", a->index().triangle_count()},
                               {"triangles_b", b->index().triangle_count()},
                               {"convex_a", a->is_convex()},
                               {"convex_b", b->is_convex()},
                               {"build_seconds", build_seconds},
                               {"rotation_error", read.rotation_error},
                               {"poses", rows}});
}

} // namespace

Command add_contacts_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "contacts", "Find how deep two closed meshes overlap, and in which contact regions");
    const auto options = std::make_shared<ContactsOptions>();
    parser->add_option("A", options->model_a, "The mesh that stands still: a file or a built-in")
        ->required()
        ->type_name("MODEL");
    parser->add_option("B", options->model_b, "The mesh that poses move")
        ->required()
        ->type_name("MODEL");
    parser
        ->add_option(
            "--pose", options->poses,
            concat("One pose of B, or a table of poses, a row each (.npy, text, - for stdin). "
                   "A pose is ",
                   pose_forms))
        ->type_name("POSE|FILE");
    parser
        ->add_option("--points", options->search.max_points,
                     "Points that are looked at for the lower bound of the depth")
        ->check(CLI::Range(0U, max_penetration_search))
        ->capture_default_str()
        ->type_name("N");
    parser
        ->add_option("--directions", options->search.max_directions,
                     "Directions round the sphere that are tried for the upper bound")
        ->check(CLI::Range(0U, max_penetration_search))
        ->capture_default_str()
        ->type_name("N");
    return {parser, [options](Session& session) { return run_contacts(*options, session); }};
}

} // namespace proxima
