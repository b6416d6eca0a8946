// Every panel, one file each.
#pragma once

#include "viewer/panel.h"

#include <memory>

namespace proxima {

[[nodiscard]] std::unique_ptr<Panel> make_model_panel();
[[nodiscard]] std::unique_ptr<Panel> make_octree_panel();

} // namespace proxima
