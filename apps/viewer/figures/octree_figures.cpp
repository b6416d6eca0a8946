// Figures 2.6, 2.7 and 3.16: octrees of models.
#include "viewer/figures/octree_figures.h"

#include "cli/octree_picture.h"
#include "cli/thesis_models.h"
#include "octree/leaf_boxes.h"
#include "proxima/execution.h"
#include "proxima/mesh_io.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"
#include "proxima/thesis.h"

#include <array>
#include <filesystem>
#include <fmt/core.h>

namespace proxima {
namespace {

constexpr ViewSize panel_size = {.width = 720, .height = 600};
constexpr ViewSize flat_panel = {.width = 720, .height = 460}; // for what is wide and low

Result<PicturePanel> picture_of(const Octree& octree, const TriangleMesh& mesh, std::string title,
                                PictureOptions options, const Execution& context)
{
    options.execution.progress = context.progress;
    auto image = draw_octree(octree, mesh, options);
    if (!image) return tl::unexpected(image.error());
    return PicturePanel{std::move(title), std::move(*image)};
}

OctreeOptions options_for(int depth, const Execution& context)
{
    return {.max_depth = depth, .execution = context};
}

/// "1 cell", "9 cells".
std::string counted(std::uint64_t count, const char* one, const char* more)
{
    return fmt::format("{} {}", count, count == 1 ? one : more);
}

CameraChoice seen_aside(const Vec3& up, ViewSize size)
{
    return {.camera = {.azimuth = 0.42, .elevation = 0.30, .up = up}, .size = size};
}

/// What holds the leaves that hold triangles.
Result<Box> box_of_leaves(const Octree& octree, const Execution& context)
{
    const auto leaves = leaf_boxes(octree, LeafChoice::boundary, context.progress);
    if (!leaves) return tl::unexpected(leaves.error());
    Box box;
    for (const LeafBox& leaf : *leaves) {
        box.extend(corner_position(octree, leaf, 0));
        box.extend(corner_position(octree, leaf, 7));
    }
    return box;
}

/// A panel for each depth, all seen from one point, and what the leaves are in words.
Result<std::string> add_depths(FigureContent& content, const TriangleMesh& mesh,
                               std::span<const int> depths, ViewSize size, const Execution& context)
{
    std::string counts;
    PictureOptions options = {.view = seen_aside(Vec3::UnitZ(), size)};
    options.depths = {depths.front(), depths.back()};
    for (const int depth : depths) {
        const auto octree = build_octree(mesh, options_for(depth, context));
        if (!octree) return tl::unexpected(octree.error());
        if (!options.frame) {
            const auto frame = box_of_leaves(*octree, context);
            if (!frame) return tl::unexpected(frame.error());
            options.frame = *frame;
        }
        const OctreeStatistics statistics = octree_statistics(*octree);
        auto panel = picture_of(*octree, mesh,
                                fmt::format("depth {}: {}, {}", depth,
                                            counted(statistics.total, "cell", "cells"),
                                            counted(statistics.boundary, "leaf holds triangles",
                                                    "leaves hold triangles")),
                                options, context);
        if (!panel) return tl::unexpected(panel.error());
        content.panels.emplace_back(std::move(*panel));
        counts += fmt::format("{}depth {}: {}, {}, {:.1f} % of them occupied, {} references",
                              counts.empty() ? "" : "; ", depth,
                              counted(statistics.total, "cell", "cells"),
                              counted(statistics.leaves, "leaf", "leaves"),
                              statistics.occupied_percent, statistics.references);
    }
    return counts;
}

/// One of the thesis's scans, and what stands in where it is not there: a file that may not be
/// there either, then a built-in.
struct BenchmarkModel {
    const thesis::Model* scan;
    const char* file;
    const char* stand_in;
};

constexpr std::array benchmark_models = {
    BenchmarkModel{&thesis::table_2_3[0], "/usr/share/glmark2/models/bunny.obj", "icosphere:5"},
    BenchmarkModel{&thesis::table_2_3[1], "/usr/share/glmark2/models/horse.3ds", "torus:80x40"},
    BenchmarkModel{&thesis::table_2_3[2], "", "torus:64x32"},
    BenchmarkModel{nullptr, "", "spaceship:33000"}};

struct LoadedModel {
    std::string name;
    TriangleMesh mesh;
    Vec3 up = Vec3::UnitZ();
};

Result<LoadedModel> load(const BenchmarkModel& model, const std::string& folder,
                         const Execution& context)
{
    if (model.scan != nullptr) {
        if (const auto scan = file_of(*model.scan, folder)) {
            auto mesh = read_mesh(*scan, {.execution = {.progress = context.progress}});
            if (!mesh) return tl::unexpected(mesh.error());
            return LoadedModel{scan->filename().string(), std::move(*mesh), Vec3::UnitY()};
        }
    }
    std::error_code error;
    const std::filesystem::path file = model.file;
    if (!file.empty() && std::filesystem::exists(file, error)) {
        auto mesh = read_mesh(file, {.execution = {.progress = context.progress}});
        if (mesh) return LoadedModel{file.filename().string(), std::move(*mesh), Vec3::UnitY()};
        // Without assimp there is no 3DS: the stand-in is shown then too.
        if (mesh.error().code != ErrorCode::unsupported_format) return tl::unexpected(mesh.error());
    }
    auto mesh = sample_mesh(model.stand_in, {.execution = {.progress = context.progress}});
    if (!mesh) return tl::unexpected(mesh.error());
    return LoadedModel{model.stand_in, std::move(*mesh), Vec3::UnitZ()};
}

} // namespace

Result<FigureContent> figure_2_6(const Execution& context)
{
    constexpr std::array depths = {0, 1, 2, 3, 4, 5};
    const auto mesh = sample_mesh("sphere:100x100", {.execution = {.progress = context.progress}});
    if (!mesh) return tl::unexpected(mesh.error());
    FigureContent content;
    const auto counts = add_depths(content, *mesh, depths, panel_size, context);
    if (!counts) return tl::unexpected(counts.error());
    content.caption = fmt::format(
        "Adaptive subdivision of a sphere of {} triangles, threshold 1: the leaves that hold "
        "triangles, coloured by depth. The deeper the octree, the closer its leaves follow the "
        "surface. {}.",
        mesh->triangle_count(), *counts);
    return content;
}

Result<FigureContent> figure_2_7(const Execution& context, const std::string& folder)
{
    FigureContent content;
    content.columns = 2;
    content.caption = "Adaptive subdivision to depth 5 with the thesis's heuristic: built with "
                      "threshold 1, and again with the longest list as threshold.";
    for (const BenchmarkModel& source : benchmark_models) {
        const auto model = load(source, folder, context);
        if (!model) return tl::unexpected(model.error());
        const OctreeOptions options = options_for(5, context);
        const auto first = build_octree(model->mesh, options);
        if (!first) return tl::unexpected(first.error());
        const auto octree = build_octree_two_pass(model->mesh, {}, options);
        if (!octree) return tl::unexpected(octree.error());
        const OctreeStatistics before = octree_statistics(*first);
        const OctreeStatistics after = octree_statistics(*octree);
        const std::uint32_t threshold = octree->parameters().threshold;
        auto panel = picture_of(*octree, model->mesh,
                                fmt::format("{}: threshold {}, {} leaves hold triangles",
                                            model->name, threshold, after.boundary),
                                {.view = seen_aside(model->up, panel_size)}, context);
        if (!panel) return tl::unexpected(panel.error());
        content.panels.emplace_back(std::move(*panel));
        content.caption += fmt::format(
            " {}, {} triangles: {} cells with threshold 1, {} with threshold {}, the longest list "
            "{} either way, on average {:.2f} and {:.2f} triangles a leaf.",
            model->name, model->mesh.triangle_count(), before.total, after.total, threshold,
            before.max_triangles, before.mean_all_leaves, after.mean_all_leaves);
        if (before.max_triangles != after.max_triangles) {
            return fail(ErrorCode::broken_invariant,
                        "the second pass made longer lists than the first", model->name);
        }
    }
    for (const thesis::Model& scan : thesis::table_2_3) {
        if (file_of(scan, folder)) continue;
        content.caption +=
            fmt::format(" The thesis shows the {} here: {}", scan.name, how_to_get(scan, folder));
    }
    return content;
}

Result<FigureContent> figure_3_16(const Execution& context)
{
    constexpr std::array depths = {3, 4, 5, 6};
    const auto mesh = make_spaceship(33000, {.execution = {.progress = context.progress}});
    if (!mesh) return tl::unexpected(mesh.error());
    FigureContent content;
    content.columns = 2;
    const auto counts = add_depths(content, *mesh, depths, flat_panel, context);
    if (!counts) return tl::unexpected(counts.error());
    content.caption = fmt::format(
        "A procedural spaceship of {} triangles, instead of the thesis's model of as many, "
        "and its octrees, threshold 1, leaves coloured by depth. {}.",
        mesh->triangle_count(), *counts);
    return content;
}

} // namespace proxima
