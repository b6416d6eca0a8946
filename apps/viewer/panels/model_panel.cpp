// The models as they are: surface, edges, and what is wrong with them.
#include "base/text.h"
#include "proxima/execution.h"
#include "proxima/mesh_report.h"
#include "viewer/panels/panels.h"

#include <algorithm>
#include <array>

namespace proxima {
namespace {

struct ModelSettings {
    bool smooth = true;
    bool edges = false;
    bool flaws = true;
};

/// Edges that a closed surface does not have, by what is wrong with them.
struct FlawColor {
    FindingKind kind;
    const char* color;
    Color ink;
};
constexpr double flaw_width = 3.0;
const std::array flaw_colors = {
    FlawColor{FindingKind::boundary_edges, "red", srgb(0xD32F2F)},
    FlawColor{FindingKind::non_manifold_edges, "violet", srgb(0x8E24AA)},
    FlawColor{FindingKind::inconsistent_edges, "orange", srgb(0xEF7D00)}};

/// Whether two triangles run along their common edge in the same direction: one of them faces
/// inward.
bool are_turned(const ViewModel& model, EdgeId edge)
{
    const auto low = model.topology.vertices(edge)[0];
    const auto high = model.topology.vertices(edge)[1];
    int forward = 0;
    for (const TriangleId id : model.topology.triangles(edge)) {
        const TriangleCorners& corners = model.mesh.triangles()[to_index(id)];
        for (std::size_t k = 0; k < 3; ++k)
            if (corners[k] == to_index(low) && corners[(k + 1) % 3] == to_index(high)) ++forward;
    }
    return forward != 1;
}

/// One of the lines for each colour; none without an edge of its kind.
void add_flaws(DrawnScene& scene, const ViewModel& model)
{
    std::array<SceneLines, flaw_colors.size()> lines;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        lines[i].name = name_of(flaw_colors[i].kind);
        lines[i].color = flaw_colors[i].ink;
        lines[i].width = flaw_width;
    }
    for (std::uint32_t e = 0; e < model.topology.edge_count(); ++e) {
        const EdgeId edge{e};
        const std::size_t sides = model.topology.triangles(edge).size();
        const std::size_t flaw = sides == 1                ? 0U
                                 : sides != 2              ? 1U
                                 : are_turned(model, edge) ? 2U
                                                           : lines.size();
        if (flaw == lines.size()) continue;
        const auto [a, b] = model.topology.vertices(edge);
        lines[flaw].segments.push_back({model.mesh.position(a), model.mesh.position(b)});
    }
    for (SceneLines& of_kind : lines)
        if (!of_kind.segments.empty()) scene.lines.push_back(std::move(of_kind));
}

/// "boundary edges".
std::string words_for(FindingKind kind)
{
    std::string words(name_of(kind));
    std::ranges::replace(words, '_', ' ');
    return words;
}

/// The flaws that are drawn.
Legend legend_of(const DrawnScene& flaws)
{
    Legend legend;
    for (const FlawColor& flaw : flaw_colors) {
        if (std::ranges::find(flaws.lines, name_of(flaw.kind), &SceneLines::name) !=
            flaws.lines.end()) {
            legend.entries.push_back({hex_of(flaw.ink), words_for(flaw.kind)});
        }
    }
    return legend;
}

std::string count_of(const MeshFinding& finding)
{
    const auto color = std::ranges::find(flaw_colors, finding.kind, &FlawColor::kind);
    if (color == flaw_colors.end()) return concat(finding.count);
    return concat(finding.count, " (", color->color, ")");
}

/// All edges, flat ones too.
void add_all_edges(DrawnScene& scene, const ViewModel& model)
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
    std::shared_ptr<const DrawnScene> flaws;
};

Result<Reports> report(const ViewModels& models, const Execution& context)
{
    Reports reports;
    auto flaws = std::make_shared<DrawnScene>();
    for (const auto& model : models) {
        auto& facts = reports.facts;
        // A file's name without its folders, which are too long for a line.
        facts.push_back({"model", model->name.substr(model->name.find_last_of('/') + 1)});
        facts.push_back({"triangles", concat(model->mesh.triangle_count())});
        facts.push_back({"vertices", concat(model->mesh.vertex_count())});
        facts.push_back({"edges", concat(model->topology.edge_count())});
        const auto found = report_mesh(model->mesh, {.execution = context});
        if (!found) return tl::unexpected(found.error());
        for (const MeshFinding& finding : found->findings)
            facts.push_back({words_for(finding.kind), count_of(finding)});
        add_flaws(*flaws, *model);
    }
    reports.flaws = std::move(flaws);
    return reports;
}

class ModelPanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "model"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The models and what is wrong with them, edges in colour. Drag to turn, right drag "
               "to move, wheel to "
               "go nearer, click to pick, double click to put a point into the middle.";
    }
    void models_changed(const ViewModels& /*models*/, const Vec3& /*to_eye*/) override
    {
        reports_ = std::make_shared<Kept<int, Reports>>();
    }

    void offer(Controls& controls) override
    {
        controls.toggle("smooth", settings_.smooth);
        controls.toggle("edges", settings_.edges);
        controls.toggle("flaws", settings_.flaws);
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, settings = settings_,
                reports = reports_](const Execution& context) -> Result<PanelPicture> {
            PanelPicture picture;
            picture.layers =
                model_layers(models, settings.smooth ? Smoothing::smooth : Smoothing::flat);
            if (settings.edges) {
                auto scene = std::make_shared<DrawnScene>();
                for (const auto& model : models) add_all_edges(*scene, *model);
                picture.layers.push_back({std::move(scene)});
            }
            const auto found = reports->get(0, [&] { return report(models, context); });
            if (!found) return tl::unexpected(found.error());
            picture.facts = (*found)->facts;
            if (settings.flaws) {
                picture.layers.push_back({(*found)->flaws});
                picture.legend = legend_of(*(*found)->flaws);
            }
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
