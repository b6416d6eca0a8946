// The octree of a model: its cells by depth, class or count, cut open by a plane.
#include "base/text.h"
#include "cli/names.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/thesis.h"
#include "viewer/panels/cell_shapes.h"
#include "viewer/panels/panels.h"

#include <algorithm>
#include <fmt/core.h>
#include <map>
#include <tuple>

namespace proxima {
namespace {

constexpr int deepest = 12;
constexpr std::size_t most_cells = 300'000; // drawn

enum class ColorBy : std::uint8_t { depth, type, count };

struct BuildSettings {
    int model = 1;
    int depth = 5;
    int threshold = 1;
    Subdivision subdivision = Subdivision::adaptive;
    std::size_t method = 0; ///< of all_methods
    bool two_pass = false;
    RootShape root = RootShape::cube;
    friend bool operator==(const BuildSettings&, const BuildSettings&) = default;
};

struct OctreePanelSettings {
    BuildSettings build;
    ColorBy color = ColorBy::depth;
    bool boundary = true;
    bool inner = false;
    bool outer = false;
    bool mesh = true;
    bool cut = false;
    int cut_axis = 1;
    double cut_at = 0.0; ///< -1 to 1 across the root
    bool cut_flipped = false;
};

struct BuiltOctree {
    Octree octree;
    OctreeStatistics statistics;
    std::vector<LeafBox> leaves;
    double seconds = 0.0;
};

Result<BuiltOctree> build(const ViewModel& model, const BuildSettings& settings,
                          const Execution& context)
{
    const OctreeOptions options = {.max_depth = settings.depth,
                                   .threshold = static_cast<std::uint32_t>(settings.threshold),
                                   .subdivision = settings.subdivision,
                                   .root_shape = settings.root,
                                   .execution = context};
    const OverlapChoice choice{.method = all_methods[settings.method]};
    const auto begin = std::chrono::steady_clock::now();
    auto octree = settings.two_pass ? build_octree_two_pass(model.mesh, choice, options)
                                    : build_octree_by(model.mesh, choice, options);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    if (!octree) return tl::unexpected(octree.error());
    auto leaves = leaf_boxes(*octree, LeafChoice::all, context.progress);
    if (!leaves) return tl::unexpected(leaves.error());
    const OctreeStatistics statistics = octree_statistics(*octree);
    return BuiltOctree{std::move(*octree), statistics, std::move(*leaves), spent.count()};
}

bool is_shown(const OctreePanelSettings& settings, const LeafBox& leaf)
{
    return leaf.type == CellClass::boundary ? settings.boundary
           : leaf.type == CellClass::inner  ? settings.inner
                                            : settings.outer;
}

/// The group of one colour that a leaf belongs to, and that colour's position from 0 to 1.
int group_of(const OctreePanelSettings& settings, const LeafBox& leaf)
{
    switch (settings.color) {
    case ColorBy::depth:
        return leaf.depth;
    case ColorBy::type:
        return static_cast<int>(leaf.type);
    case ColorBy::count:
        break;
    }
    return static_cast<int>(std::bit_width(leaf.triangles)); // 0, 1, 2-3, 4-7, ...
}

Color color_of_group(const OctreePanelSettings& settings, int group,
                     const OctreeStatistics& statistics)
{
    if (settings.color == ColorBy::type) return class_color(static_cast<CellClass>(group));
    const int most = settings.color == ColorBy::depth
                         ? std::max(statistics.depth_reached, 1)
                         : std::max(static_cast<int>(std::bit_width(statistics.max_triangles)), 1);
    return ramp_color(static_cast<double>(group) / most);
}

using Groups = std::map<int, std::vector<LeafBox>>;

/// Leaves that are shown, by colour, as many as can be drawn: larger ones first. And their number.
std::pair<Groups, std::size_t> shown_groups(const OctreePanelSettings& settings,
                                            const BuiltOctree& built)
{
    std::vector<LeafBox> shown;
    for (const LeafBox& leaf : built.leaves)
        if (is_shown(settings, leaf)) shown.push_back(leaf);
    const std::size_t all = shown.size();
    if (all > most_cells) {
        std::ranges::stable_sort(shown, std::ranges::greater{}, &LeafBox::size);
        shown.resize(most_cells);
    }
    Groups groups;
    for (const LeafBox& leaf : shown) groups[group_of(settings, leaf)].push_back(leaf);
    return {std::move(groups), all};
}

std::string words_for_group(ColorBy color, int group)
{
    if (color == ColorBy::depth) return concat("depth ", group);
    if (color == ColorBy::type) {
        constexpr std::array words = {"outer", "inner", "boundary", "unclassified"};
        return words[static_cast<std::size_t>(group)];
    }
    if (group < 2) return concat(group);
    return concat(1U << (group - 1), " to ", (1U << group) - 1);
}

/// The colours of cells that are shown.
Legend legend_of(const OctreePanelSettings& settings, const Groups& groups,
                 const OctreeStatistics& statistics)
{
    Legend legend;
    if (settings.color == ColorBy::count) legend.title = "triangles in a leaf";
    for (const auto& [group, leaves] : groups) {
        legend.entries.push_back({hex_of(color_of_group(settings, group, statistics)),
                                  words_for_group(settings.color, group)});
    }
    return legend;
}

std::shared_ptr<const DrawnScene> cells_scene(const OctreePanelSettings& settings,
                                              const BuiltOctree& built, const Groups& groups)
{
    auto scene = std::make_shared<DrawnScene>();
    for (const auto& [group, leaves] : groups) {
        add_leaf_edges(*scene, built.octree, leaves,
                       {.name = "cells",
                        .color = color_of_group(settings, group, built.statistics),
                        .width = 1.3,
                        .opacity = 0.85F});
    }
    return scene;
}

/// What the cut plane goes through, filled.
std::shared_ptr<const DrawnScene> slice_scene(const OctreePanelSettings& settings,
                                              const BuiltOctree& built, const AxisPlane& plane)
{
    auto scene = std::make_shared<DrawnScene>();
    std::map<int, std::vector<Box>> slices;
    std::vector<Box> all;
    for (const LeafBox& leaf : built.leaves) {
        if (!is_shown(settings, leaf)) continue;
        const Box slice = slice_of(built.octree, leaf, plane);
        if (slice.empty()) continue;
        slices[group_of(settings, leaf)].push_back(slice);
        all.push_back(slice);
    }
    for (const auto& [group, boxes] : slices) {
        add_slices(*scene, boxes, plane.axis,
                   {.name = "cut cells",
                    .color = color_of_group(settings, group, built.statistics),
                    .lighting = Lighting::flat});
    }
    add_box_edges(*scene, all, {.name = "cut cells' edges", .color = srgb(0x30343B), .width = 1.0});
    return scene;
}

void add_facts(PanelPicture& picture, const BuiltOctree& built, std::size_t shown)
{
    const OctreeStatistics& s = built.statistics;
    const auto add = [&](const char* name, std::string value) {
        picture.facts.push_back({name, std::move(value)});
    };
    add("cells", concat(s.total));
    add("leaves", concat(s.leaves));
    add("boundary", concat(s.boundary));
    add("inner", concat(s.inner));
    add("outer", concat(s.outer));
    add("occupied", fmt::format("{:.2f} %", s.occupied_percent));
    add("references", concat(s.references));
    add("triangles in a leaf", concat(s.min_triangles, " to ", s.max_triangles));
    add("mean, deviation", fmt::format("{:.2f}, {:.2f}", s.mean_triangles, s.std_triangles));
    add("depth reached", concat(s.depth_reached));
    add("threshold used", concat(built.octree.parameters().threshold));
    add("memory", fmt::format("{:.2f} MB", 1e-6 * static_cast<double>(s.bytes)));
    add("built in", fmt::format("{:.1f} ms", 1e3 * built.seconds));
    if (shown > most_cells) add("drawn", concat("the largest ", most_cells, " of ", shown));
    PanelPlot plot = {"leaves by depth", {}, true};
    for (int depth = 0; depth <= s.depth_reached; ++depth) {
        plot.values.push_back(
            static_cast<float>(s.leaves_at_depth[static_cast<std::size_t>(depth)]));
    }
    picture.plots.push_back(std::move(plot));
}

class OctreePanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "octree"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The octree: cells that hold triangles, and those known to lie inside or outside.";
    }

    void models_changed(const ViewModels& models, const Vec3& /*to_eye*/) override
    {
        models_ = static_cast<int>(models.size());
        settings_.build.model = std::clamp(settings_.build.model, 1, models_);
        kept_ = std::make_shared<Kept<BuildSettings, BuiltOctree>>();
    }

    void offer(Controls& controls) override
    {
        BuildSettings& build = settings_.build;
        offer_model(controls, build.model, static_cast<std::size_t>(models_));
        controls.number("depth", build.depth, 0, deepest);
        controls.number("threshold", build.threshold, 1, 1000);
        choose(controls, "subdivision", build.subdivision,
               std::array<std::string_view, 2>{"adaptive", "uniform"});
        std::array<std::string_view, all_methods.size()> methods;
        std::ranges::transform(all_methods, methods.begin(), method_name);
        controls.choice("method", build.method, methods);
        controls.toggle("two pass", build.two_pass);
        choose(controls, "root", build.root, std::array<std::string_view, 2>{"cube", "box"});
        choose(controls, "colour by", settings_.color,
               std::array<std::string_view, 3>{"depth", "class", "count"});
        controls.toggle("boundary", settings_.boundary);
        controls.toggle("inner", settings_.inner);
        controls.toggle("outer", settings_.outer);
        controls.toggle("mesh", settings_.mesh);
        controls.toggle("cut plane", settings_.cut);
        const OfferedIf with_plane(controls, "cut plane=on", settings_.cut);
        auto axis = static_cast<std::size_t>(settings_.cut_axis);
        if (controls.choice("cut axis", axis, std::array<std::string_view, 3>{"x", "y", "z"}))
            settings_.cut_axis = static_cast<int>(axis);
        controls.number("cut at", settings_.cut_at, -1.0, 1.0);
        controls.toggle("other side", settings_.cut_flipped);
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [model = models[static_cast<std::size_t>(settings_.build.model - 1)],
                settings = settings_,
                kept = kept_](const Execution& context) -> Result<PanelPicture> {
            const auto built =
                kept->get(settings.build, [&] { return build(*model, settings.build, context); });
            if (!built) return tl::unexpected(built.error());
            PanelPicture picture;
            const auto [groups, shown] = shown_groups(settings, **built);
            std::optional<HalfSpace> cut;
            if (settings.cut) {
                const Box root = (*built)->octree.box((*built)->octree.root());
                const int axis = settings.cut_axis;
                const AxisPlane plane = {axis, root.center()[axis] +
                                                   0.5 * settings.cut_at * root.extent()[axis]};
                // The side where the eye stands at first is taken away.
                const bool eye_is_lower = axis == 1 && model->up.z() > 0.5;
                const double side = settings.cut_flipped == eye_is_lower ? 1.0 : -1.0;
                cut = HalfSpace{side * Vec3::Unit(axis), side * plane.at};
                picture.layers.push_back({slice_scene(settings, **built, plane)});
            }
            if (settings.mesh) picture.layers.push_back({.scene = model->smooth, .cut = cut});
            picture.layers.push_back({.scene = cells_scene(settings, **built, groups), .cut = cut});
            // Cells that stand out of the model are to be seen, too.
            const Box drawn = bounding_box(picture.layers);
            if (drawn.extent().norm() > 1.1 * model->box.extent().norm()) picture.focus = drawn;
            picture.legend = legend_of(settings, groups, (*built)->statistics);
            add_facts(picture, **built, shown);
            return picture;
        };
    }

private:
    OctreePanelSettings settings_;
    int models_ = 0;
    std::shared_ptr<Kept<BuildSettings, BuiltOctree>> kept_ =
        std::make_shared<Kept<BuildSettings, BuiltOctree>>();
};

} // namespace

std::unique_ptr<Panel> make_octree_panel()
{
    return std::make_unique<OctreePanel>();
}

} // namespace proxima
