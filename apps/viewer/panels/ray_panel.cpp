// A ray through an octree: the cells along it, lit by their weights, and what it hits: figures 5.5
// and 5.6.
#include "proxima/cast_ray.h"
#include "proxima/cells_along_ray.h"
#include "proxima/execution.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/panels/shared_octree.h"
#include "viewer/query_shapes.h"

#include <fmt/core.h>

namespace proxima {
namespace {

enum class RayWeight : std::uint8_t { penetration, chord };

struct RaySettings {
    OctreeChoice octree;
    RayWeight weight = RayWeight::penetration;
    bool occupied_only = false;
    double mesh_opacity = 0.35;
    PlacedPoint from;
    PlacedPoint towards;
};

std::shared_ptr<const DrawnScene> ray_scene(const RaySettings& settings, const Octree& octree,
                                            const Ray& ray, std::span<const CellOnRay> cells,
                                            std::span<const RayHit> hits, double size)
{
    auto scene = std::make_shared<DrawnScene>();
    std::vector<Box> boxes;
    for (const CellOnRay& at : cells) {
        const double weight =
            settings.weight == RayWeight::penetration ? at.penetration : chord_weight(octree, at);
        const Box box = octree.box(at.cell);
        boxes.push_back(box);
        add_box(*scene, box,
                {.name = "cell", .color = intensity_color(weight), .lighting = Lighting::flat});
    }
    add_box_edges(*scene, boxes, {.name = "cells' edges", .color = srgb(0x7A7A7A), .width = 1.3});
    const ShapeStyle arrow = {.name = "ray", .color = srgb(figure_colors::red)};
    const Vec3 along = ray.direction.stableNormalized();
    const double begin = cells.empty() ? 0.5 * size : cells.front().enter * ray.direction.norm();
    const double end = cells.empty() ? size : cells.back().exit * ray.direction.norm();
    const auto at = [&](double length) -> Vec3 { return ray.origin + length * along; };
    if (begin > 0.02 * size) {
        add_arrow(*scene, at(std::max(0.0, begin - 0.4 * size)), at(begin - 0.005 * size),
                  0.006 * size, arrow);
    }
    add_arrow(*scene, at(end + 0.005 * size), at(end + 0.25 * size), 0.006 * size, arrow);
    for (const RayHit& hit : hits) {
        add_ball(*scene, ray.at(hit.t), 0.009 * size,
                 {.name = "hit", .color = srgb(figure_colors::blue), .lift = 1e-2});
    }
    return scene;
}

class RayPanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "rays"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "Cells along a ray, black for no weight and yellow for all: how deep the ray goes "
               "into a cell (thesis) or how long it is in it. Drag the rings: where it begins, and "
               "where it goes; a click sends it to a point.";
    }

    void models_changed(const ViewModels& models, const Vec3& /*to_eye*/) override
    {
        models_ = models;
        kept_ = std::make_shared<KeptOctree>();
        settings_.octree.model =
            std::clamp(settings_.octree.model, 1, static_cast<int>(models.size()));
        settings_.from.place(point_at_offset(*model(), -0.62, 0.3, 0.14));
        settings_.towards.place(point_at_offset(*model(), 0.02, -0.01, 0.03));
    }

    void offer(Controls& controls) override
    {
        offer_model(controls, settings_.octree.model, models_.size());
        settings_.octree.offer(controls);
        choose(controls, "weight", settings_.weight,
               std::array<std::string_view, 2>{"penetration", "chord"});
        controls.toggle("occupied only", settings_.occupied_only);
        controls.number("mesh opacity", settings_.mesh_opacity, 0.0, 1.0);
        settings_.from.offer(controls, "from", models_);
        settings_.towards.offer(controls, "towards", models_);
    }

    [[nodiscard]] std::vector<Vec3> handles() const override
    {
        return {settings_.from.at, settings_.towards.at};
    }
    void move_handle(std::size_t handle, const Vec3& to) override
    {
        (handle == 0 ? settings_.from : settings_.towards).set(to);
    }
    bool picked(const PickedPoint& hit) override
    {
        settings_.octree.model = static_cast<int>(hit.model) + 1;
        settings_.towards.set(hit.point);
        return true;
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, model = model(), settings = settings_,
                kept = kept_](const Execution& context) -> Result<PanelPicture> {
            const auto octree = octree_of(*kept, settings.octree, *model, context);
            if (!octree) return tl::unexpected(octree.error());
            const Ray ray = {.origin = settings.from.at,
                             .direction = settings.towards.at - settings.from.at};
            if (!is_valid(ray)) {
                return fail(ErrorCode::invalid_argument,
                            "the ray begins where it goes to: move one of its ends");
            }
            std::vector<CellOnRay> cells = cells_along_ray(**octree, ray);
            const std::size_t all = cells.size();
            double chords = 0.0;
            for (const CellOnRay& at : cells) chords += at.chord;
            if (settings.occupied_only) {
                std::erase_if(
                    cells, [](const CellOnRay& at) { return at.cell.type != CellClass::boundary; });
            }
            const std::vector<RayHit> hits = all_hits(model->rays, ray);
            PanelPicture picture;
            const double size = model->box.extent().norm();
            picture.layers.push_back({ray_scene(settings, **octree, ray, cells, hits, size)});
            picture.focus = bounding_box(models);
            const Box drawn = bounding_box(picture.layers);
            picture.focus->extend(drawn.lower);
            picture.focus->extend(drawn.upper);
            for (SceneLayer& layer : model_layers(models, Smoothing::smooth)) {
                layer.opacity = static_cast<float>(settings.mesh_opacity);
                if (layer.opacity > 0.0F) picture.layers.push_back(std::move(layer));
            }
            picture.legend.title = settings.weight == RayWeight::penetration
                                       ? "penetration of a cell"
                                       : "chord per diagonal of a cell";
            if (cells.empty()) picture.legend.title.clear();
            for (const int quarters : {0, 1, 2, 3, 4}) {
                if (cells.empty()) break;
                const double weight = 0.25 * quarters;
                picture.legend.entries.push_back(
                    {hex_of(intensity_color(weight)), fmt::format("{:.2f}", weight)});
            }
            if (!hits.empty())
                picture.legend.entries.push_back({figure_colors::blue, "surface that is hit"});
            picture.facts = {{"cells along the ray", fmt::format("{}", all)},
                             {"shown", fmt::format("{}", cells.size())},
                             {"length in the root", fmt::format("{:.6g}", chords)},
                             {"triangles hit", fmt::format("{}", hits.size())}};
            if (!hits.empty()) {
                picture.facts.push_back(
                    {"first hit", fmt::format("triangle {} at {:.6g}", to_index(hits[0].triangle),
                                              hits[0].t * ray.direction.norm())});
            }
            PanelPlot weights = {"weight of cell by cell", {}, true};
            for (const CellOnRay& at : cells) {
                weights.values.push_back(static_cast<float>(
                    settings.weight == RayWeight::penetration ? at.penetration
                                                              : chord_weight(**octree, at)));
            }
            if (!weights.values.empty()) picture.plots.push_back(std::move(weights));
            return picture;
        };
    }

private:
    [[nodiscard]] const std::shared_ptr<const ViewModel>& model() const
    {
        return models_[static_cast<std::size_t>(settings_.octree.model - 1)];
    }

    RaySettings settings_;
    ViewModels models_;
    std::shared_ptr<KeptOctree> kept_ = std::make_shared<KeptOctree>();
};

} // namespace

std::unique_ptr<Panel> make_ray_panel()
{
    return std::make_unique<RayPanel>();
}

} // namespace proxima
