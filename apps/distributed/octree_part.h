// A rank's part of an octree that is spread over the ranks.
#pragma once

#include "distributed/route_triangles.h"
#include "proxima/octree.h"

#include <cstdint>
#include <vector>

namespace proxima {

struct OctreePart {
    RoutedPart routed;
    /// Made by grow_part with CellsElsewhere::recorded, and classified. Lists have ids of routed.mesh.
    Octree octree;
    std::vector<Cell> cells;         ///< this rank's, in Morton order
    std::uint32_t upper_records = 0; ///< as GrownPart::upper_records
};

} // namespace proxima
