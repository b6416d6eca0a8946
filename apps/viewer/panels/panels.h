// Every panel, one file each.
#pragma once

#include "viewer/panel.h"
#include "viewer/panels/shared_proximity.h"

#include <memory>

namespace proxima {

[[nodiscard]] std::unique_ptr<Panel> make_model_panel();
[[nodiscard]] std::unique_ptr<Panel> make_octree_panel();
[[nodiscard]] std::unique_ptr<Panel> make_minkowski_panel();
[[nodiscard]] std::unique_ptr<Panel> make_voronoi_panel(std::shared_ptr<SharedProximity> proximity);
[[nodiscard]] std::unique_ptr<Panel> make_closest_panel(std::shared_ptr<SharedProximity> proximity);
[[nodiscard]] std::unique_ptr<Panel> make_ray_panel();
[[nodiscard]] std::unique_ptr<Panel> make_culling_panel();
[[nodiscard]] std::unique_ptr<Panel> make_intersection_panel();
[[nodiscard]] std::unique_ptr<Panel> make_touch_panel(Pictures pictures);

} // namespace proxima
