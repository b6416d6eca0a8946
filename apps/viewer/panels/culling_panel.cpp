// Culling by the volume of a second camera: figures 5.7 and 5.8.
#include "proxima/cull.h"
#include "proxima/execution.h"
#include "proxima/view_volume.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/panels/shared_octree.h"
#include "viewer/query_shapes.h"

#include <fmt/core.h>
#include <numbers>

namespace proxima {
namespace {

constexpr unsigned visible_color = 0xF2D9A0;
constexpr unsigned hidden_color = 0x8D99A8;

struct CullingSettings {
    OctreeChoice octree = {.model = 1, .depth = 5, .threshold = 40};
    CullMode mode = CullMode::conservative;
    double degrees = 24.0;
    double aspect = 1.3;
    double near = 0.3; ///< per diagonal
    double far = 1.3;  ///< per diagonal
    bool cells = true;
    PlacedPoint eye;
    PlacedPoint target;
};

PerspectiveCamera second_camera(const CullingSettings& settings, const ViewModel& model)
{
    const double size = model.box.extent().norm();
    return {.eye = settings.eye.at,
            .forward = settings.target.at - settings.eye.at,
            .up = model.up,
            .field_of_view = settings.degrees * std::numbers::pi / 180.0,
            .aspect = settings.aspect,
            .near = settings.near * size,
            .far = settings.far * size};
}

class CullingPanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "culling"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "What a second camera sees (red): triangles in its volume are light, the others "
               "gray; visible leaves that hold triangles green. Drag the rings: its eye, and where "
               "it looks.";
    }

    void models_changed(const ViewModels& models, const Vec3& /*to_eye*/) override
    {
        models_ = models;
        kept_ = std::make_shared<KeptOctree>();
        settings_.octree.model =
            std::clamp(settings_.octree.model, 1, static_cast<int>(models.size()));
        settings_.eye.place(point_at_offset(*model(), -0.45, 0.6, 0.28));
        settings_.target.place(point_at_offset(*model(), 0.05, -0.06, -0.03));
    }

    void offer(Controls& controls) override
    {
        offer_model(controls, settings_.octree.model, models_.size());
        settings_.octree.offer(controls);
        choose(controls, "mode", settings_.mode,
               std::array<std::string_view, 2>{"conservative", "exact"});
        controls.number("field of view", settings_.degrees, 1.0, 150.0);
        controls.number("aspect", settings_.aspect, 0.2, 5.0);
        controls.number("near", settings_.near, 0.001, 2.0);
        controls.number("far", settings_.far, 0.01, 5.0);
        controls.toggle("cells", settings_.cells);
        settings_.eye.offer(controls, "eye", models_);
        settings_.target.offer(controls, "target", models_);
    }

    [[nodiscard]] std::vector<Vec3> handles() const override
    {
        return {settings_.eye.at, settings_.target.at};
    }
    void move_handle(std::size_t handle, const Vec3& to) override
    {
        (handle == 0 ? settings_.eye : settings_.target).set(to);
    }

    /// The volume too.
    [[nodiscard]] Box extent(const ViewModels& models) const override
    {
        Box box = bounding_box(models);
        if (models.empty()) return box;
        box.extend(settings_.eye.at);
        for (const Vec3& corner : frustum_corners(second_camera(settings_, *model())))
            box.extend(corner);
        return box;
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, model = model(), settings = settings_,
                kept = kept_](const Execution& context) -> Result<PanelPicture> {
            const auto octree = octree_of(*kept, settings.octree, *model, context);
            if (!octree) return tl::unexpected(octree.error());
            const PerspectiveCamera camera = second_camera(settings, *model);
            const auto volume = make_perspective_volume(camera);
            if (!volume) return tl::unexpected(volume.error());
            std::vector<Box> boxes;
            std::size_t leaves = 0;
            std::size_t inside = 0;
            visible_cells(**octree, *volume, settings.mode, [&](const VisibleCell& at) {
                ++leaves;
                if (at.is_inside) ++inside;
                if (at.cell.type == CellClass::boundary) boxes.push_back((*octree)->box(at.cell));
                return Flow::proceed;
            });
            const auto visible = visible_triangles(model->rays, *volume, settings.mode);
            auto scene = std::make_shared<DrawnScene>();
            add_part(*scene, model->mesh, visible,
                     {.name = "visible", .color = srgb(visible_color), .lift = 1.5e-4});
            if (settings.cells) {
                add_box_edges(*scene, boxes,
                              {.name = "visible leaves",
                               .color = srgb(figure_colors::green),
                               .width = 1.3,
                               .opacity = 0.75F});
            }
            add_frustum(*scene, camera,
                        {.name = "volume", .color = srgb(figure_colors::red), .width = 2.5});
            PanelPicture picture;
            picture.layers = model_layers(models, Smoothing::flat);
            for (SceneLayer& layer : picture.layers) layer.color = srgb(hidden_color);
            picture.layers.push_back({std::move(scene)});
            picture.legend.entries = {{figure_colors::red, "volume of the second camera"}};
            if (!visible.empty())
                picture.legend.entries.push_back({visible_color, "triangles in it"});
            if (visible.size() < model->mesh.triangle_count())
                picture.legend.entries.push_back({hidden_color, "other triangles"});
            if (settings.cells && !boxes.empty())
                picture.legend.entries.push_back({figure_colors::green, "leaves in it"});
            const auto all = static_cast<double>(model->mesh.triangle_count());
            picture.facts = {
                {"triangles", fmt::format("{}", model->mesh.triangle_count())},
                {"visible", fmt::format("{} ({:.1f} %)", visible.size(),
                                        100.0 * static_cast<double>(visible.size()) / all)},
                {"visible leaves", fmt::format("{}", leaves)},
                {"of them wholly inside", fmt::format("{}", inside)},
                {"holding triangles", fmt::format("{}", boxes.size())}};
            return picture;
        };
    }

private:
    [[nodiscard]] const std::shared_ptr<const ViewModel>& model() const
    {
        return models_[static_cast<std::size_t>(settings_.octree.model - 1)];
    }

    CullingSettings settings_;
    ViewModels models_;
    std::shared_ptr<KeptOctree> kept_ = std::make_shared<KeptOctree>();
};

} // namespace

std::unique_ptr<Panel> make_culling_panel()
{
    return std::make_unique<CullingPanel>();
}

} // namespace proxima
