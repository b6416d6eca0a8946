// The feature of a model closest to a cursor, its neighbours, and the leaf that knew: figure 5.2.
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "proxima/closest_feature.h"
#include "proxima/execution.h"
#include "proxima/neighbourhood.h"
#include "query/closest/find_closest.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace proxima {
namespace {

constexpr double cursor_height = 0.04; // above the surface, per diagonal

constexpr unsigned listed_color = 0xF2D9A0;

struct ClosestSettings {
    int model = 1;
    int rings = 1;
    bool leaf = true;
    bool listed = false;
    PlacedPoint cursor;
};

std::shared_ptr<const DrawnScene> closest_scene(const ViewModel& model,
                                                const ClosestSettings& settings,
                                                const ClosestFeature& closest,
                                                std::span<const TriangleId> patch,
                                                const std::optional<ProximityLeaf>& leaf)
{
    auto scene = std::make_shared<DrawnScene>();
    if (settings.listed && leaf) {
        add_part(*scene, model.mesh, leaf->listed,
                 {.name = "listed", .color = srgb(listed_color), .lift = 2e-4});
    }
    add_part(*scene, model.mesh, patch,
             {.name = "patch", .color = srgb(figure_colors::blue), .lift = 5e-4});
    add_feature(*scene, model, closest.feature, mark_radius(model), srgb(figure_colors::red));
    if (settings.leaf && leaf) add_leaf(*scene, *leaf);
    add_cursor(*scene, model, settings.cursor.at);
    scene->lines.push_back(
        {"distance", {{settings.cursor.at, closest.point}}, srgb(figure_colors::ink), 2.0});
    return scene;
}

class ClosestPanel final : public Panel {
public:
    explicit ClosestPanel(std::shared_ptr<SharedProximity> proximity)
        : proximity_(std::move(proximity))
    {}

    [[nodiscard]] std::string_view name() const override { return "closest"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The feature closest to the cursor in red, the triangles round it in blue, the leaf "
               "of the proximity octree in green. Drag the ring; a click puts the cursor above a "
               "point.";
    }

    void models_changed(const ViewModels& models, const Vec3& to_eye) override
    {
        models_ = models;
        settings_.model = std::clamp(settings_.model, 1, static_cast<int>(models.size()));
        settings_.cursor.place(visible_point(*model(), to_eye, cursor_height)
                                   .above(cursor_height * model()->box.extent().norm()));
    }

    void offer(Controls& controls) override
    {
        offer_model(controls, settings_.model, models_.size());
        controls.number("rings", settings_.rings, 0, 8);
        controls.toggle("leaf", settings_.leaf);
        controls.toggle("listed", settings_.listed);
        settings_.cursor.offer(controls, "cursor", models_);
    }

    [[nodiscard]] std::vector<Vec3> handles() const override { return {settings_.cursor.at}; }
    void move_handle(std::size_t /*handle*/, const Vec3& to) override { settings_.cursor.set(to); }

    bool picked(const PickedPoint& hit) override
    {
        settings_.model = static_cast<int>(hit.model) + 1;
        const ViewModel& picked = *models_[hit.model];
        const Vec3 normal = scaled_normal(picked.mesh.triangle(hit.triangle)).stableNormalized();
        settings_.cursor.set(hit.point + cursor_height * picked.box.extent().norm() * normal);
        return true;
    }

    [[nodiscard]] Box focus(const ViewModels& models) const override
    {
        return models.empty() ? Box{} : close_up(*model(), settings_.cursor.at, 0.045);
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, model = model(), settings = settings_,
                proximity = proximity_](const Execution& context) -> Result<PanelPicture> {
            const auto with = proximity_of(*proximity, model, context);
            if (!with) return tl::unexpected(with.error());
            QuerySteps steps;
            const ClosestFeature closest = *closest_feature(**with, settings.cursor.at, {}, steps);
            NeighbourhoodScratch scratch(model->mesh);
            std::vector<TriangleId> patch(model->mesh.triangle_count());
            const Neighbourhood near = collect_rings(model->mesh, model->topology, closest.feature,
                                                     settings.rings, scratch, patch);
            patch.resize(near.written);
            if (closest.feature.kind == FeatureKind::face) std::erase(patch, closest.triangle);
            std::ranges::sort(patch);
            const auto leaf = leaf_at(**with, settings.cursor.at);
            PanelPicture picture;
            picture.layers = model_layers(models, Smoothing::flat);
            picture.layers.push_back({closest_scene(*model, settings, closest, patch, leaf)});
            picture.legend.entries = {{figure_colors::red, "closest feature"}};
            if (!patch.empty())
                picture.legend.entries.push_back({figure_colors::blue, "triangles round it"});
            if (settings.leaf && leaf)
                picture.legend.entries.push_back({figure_colors::green, "leaf of the cursor"});
            if (settings.listed && leaf)
                picture.legend.entries.push_back({listed_color, "triangles that it lists"});
            picture.facts = {
                {"closest", words_for(closest.feature)},
                {"distance", fmt::format("{:.6g}", std::sqrt(closest.squared_distance))},
                {"point", fmt::format("{:.4g}, {:.4g}, {:.4g}", closest.point.x(),
                                      closest.point.y(), closest.point.z())},
                {"triangle", fmt::format("{}", to_index(closest.triangle))},
                {"patch", fmt::format("{} triangles in {} rings", near.written, settings.rings)},
                {"leaf", leaf ? fmt::format("depth {}, {} triangles listed", leaf->depth,
                                            leaf->listed.size())
                              : "outside of the root"},
                {"steps of the query", fmt::format("{} words, {} blocks, {} rechecks", steps.steps,
                                                   steps.blocks, steps.rechecks)},
                {"worst case",
                 fmt::format("{} words, {} blocks",
                             (*with)->parts().lists()->statistics().worst_case_steps,
                             (*with)->parts().lists()->statistics().worst_case_blocks)}};
            return picture;
        };
    }

private:
    [[nodiscard]] const std::shared_ptr<const ViewModel>& model() const
    {
        return models_[static_cast<std::size_t>(settings_.model - 1)];
    }

    ClosestSettings settings_;
    ViewModels models_;
    std::shared_ptr<SharedProximity> proximity_;
};

} // namespace

std::unique_ptr<Panel> make_closest_panel(std::shared_ptr<SharedProximity> proximity)
{
    return std::make_unique<ClosestPanel>(std::move(proximity));
}

} // namespace proxima
