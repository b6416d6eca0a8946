#include "viewer/panels/panels.h"

namespace proxima {

std::vector<std::unique_ptr<Panel>> make_panels(Pictures pictures)
{
    const auto proximity = std::make_shared<SharedProximity>();
    std::vector<std::unique_ptr<Panel>> panels;
    panels.push_back(make_model_panel());
    panels.push_back(make_octree_panel());
    panels.push_back(make_minkowski_panel());
    panels.push_back(make_voronoi_panel(proximity));
    panels.push_back(make_closest_panel(proximity));
    panels.push_back(make_ray_panel());
    panels.push_back(make_culling_panel());
    panels.push_back(make_intersection_panel());
    panels.push_back(make_touch_panel(pictures));
    return panels;
}

std::vector<SceneLayer> model_layers(const ViewModels& models, Smoothing smoothing)
{
    std::vector<SceneLayer> layers;
    for (const auto& model : models)
        layers.push_back({smoothing == Smoothing::flat ? model->flat : model->smooth});
    return layers;
}

} // namespace proxima
