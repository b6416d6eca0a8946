#include "viewer/panels/shared_proximity.h"

#include "base/text.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "query/closest/leaf_candidates.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <array>

namespace proxima {

Result<std::shared_ptr<const MeshIndex>> proximity_of(SharedProximity& shared,
                                                      const std::shared_ptr<const ViewModel>& model,
                                                      const Execution& context)
{
    return shared.get(model, [&] { return with_lists(model->rays, {.execution = context}); });
}

std::optional<ProximityLeaf> leaf_at(const MeshIndex& index, const Vec3& p)
{
    ProximityLeaf leaf;
    leaf.listed.resize(index.parts().lists()->statistics().max_list);
    const auto found = leaf_candidates(index.parts(), p, leaf.listed);
    if (!found) return std::nullopt;
    leaf.box = found->box;
    leaf.depth = found->depth;
    leaf.listed.resize(found->count);
    return leaf;
}

void add_leaf(DrawnScene& scene, const ProximityLeaf& leaf)
{
    const Color green = srgb(figure_colors::green);
    add_box(scene, leaf.box, {.name = "leaf", .color = green, .opacity = 0.2F});
    add_box_edges(scene, std::array{leaf.box}, {.name = "leaf", .color = green, .width = 2.0});
}

double mark_radius(const ViewModel& model)
{
    return std::min(0.012 * model.box.extent().norm(), 0.5 * model.edge);
}

void add_cursor(DrawnScene& scene, const ViewModel& model, const Vec3& at)
{
    add_ball(scene, at, mark_radius(model), {.name = "cursor", .color = srgb(figure_colors::ink)});
}

std::string words_for(const Feature& feature)
{
    constexpr std::array kinds = {"vertex ", "edge ", "face "};
    return concat(kinds[static_cast<std::size_t>(feature.kind)], feature.id);
}

void add_feature(DrawnScene& scene, const ViewModel& model, const Feature& feature,
                 double ball_radius, const Color& color)
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        add_ball(scene, model.mesh.position(VertexId{feature.id}), ball_radius,
                 {.name = "feature", .color = color, .lift = 2e-3});
        return;
    case FeatureKind::edge: {
        const auto [a, b] = model.topology.vertices(EdgeId{feature.id});
        scene.lines.push_back(
            {"feature", {{model.mesh.position(a), model.mesh.position(b)}}, color, 6.0});
        return;
    }
    case FeatureKind::face:
        add_part(scene, model.mesh, std::array{TriangleId{feature.id}},
                 {.name = "feature", .color = color, .lift = 1e-3});
    }
}

} // namespace proxima
