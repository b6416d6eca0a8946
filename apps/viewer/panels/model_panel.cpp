// The models as they are: surface, edges, and what is wrong with them.
#include "proxima/base/text.h"
#include "proxima/mesh/mesh_report.h"
#include "viewer/panels/panels.h"

namespace proxima {
namespace {

struct ModelSettings {
    bool smooth = true;
    bool edges = false;
};

/// All edges, flat ones too.
void add_all_edges(Scene& scene, const ViewModel& model)
{
    SceneLines lines{"edges", {}, srgb(0x4A4E57), 1.0, 0.55F};
    lines.segments.reserve(model.topology.edge_count());
    for (std::uint32_t e = 0; e < model.topology.edge_count(); ++e) {
        const auto [a, b] = model.topology.vertices(EdgeId{e});
        lines.segments.push_back({model.mesh.position(a), model.mesh.position(b)});
    }
    scene.lines.push_back(std::move(lines));
}

struct Reports {
    std::vector<PanelFact> facts;
};

Result<Reports> report(const ViewModels& models, const WorkContext& context)
{
    Reports reports;
    for (const auto& model : models) {
        auto& facts = reports.facts;
        facts.push_back({"model", model->name});
        facts.push_back({"triangles", concat(model->mesh.triangle_count())});
        facts.push_back({"vertices", concat(model->mesh.vertex_count())});
        facts.push_back({"edges", concat(model->topology.edge_count())});
        const auto found = report_mesh(
            model->mesh,
            {.threads = context.threads, .budget = context.budget, .progress = context.progress});
        if (!found) return tl::unexpected(found.error());
        for (const MeshFinding& finding : found->findings)
            facts.push_back({std::string(name_of(finding.kind)), concat(finding.count)});
    }
    return reports;
}

class ModelPanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "model"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The models and what is wrong with them. Drag to turn, right drag to move, wheel to "
               "go nearer, click to pick, double click to make a place the middle.";
    }
    void models_changed(const ViewModels& /*models*/) override
    {
        reports_ = std::make_shared<Kept<int, Reports>>();
    }

    void offer(Controls& controls) override
    {
        controls.toggle("smooth", settings_.smooth);
        controls.toggle("edges", settings_.edges);
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, settings = settings_,
                reports = reports_](const WorkContext& context) -> Result<PanelPicture> {
            PanelPicture picture;
            picture.layers =
                model_layers(models, settings.smooth ? Smoothing::smooth : Smoothing::flat);
            if (settings.edges) {
                auto scene = std::make_shared<Scene>();
                for (const auto& model : models) add_all_edges(*scene, *model);
                picture.layers.push_back({std::move(scene)});
            }
            const auto found = reports->get(0, [&] { return report(models, context); });
            if (!found) return tl::unexpected(found.error());
            picture.facts = (*found)->facts;
            return picture;
        };
    }

private:
    ModelSettings settings_;
    std::shared_ptr<Kept<int, Reports>> reports_ = std::make_shared<Kept<int, Reports>>();
};

} // namespace

std::unique_ptr<Panel> make_model_panel()
{
    return std::make_unique<ModelPanel>();
}

} // namespace proxima
