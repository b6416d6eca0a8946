#include "viewer/panels/panels.h"

namespace proxima {

std::vector<std::unique_ptr<Panel>> make_panels()
{
    std::vector<std::unique_ptr<Panel>> panels;
    panels.push_back(make_model_panel());
    panels.push_back(make_octree_panel());
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
