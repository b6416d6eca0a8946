// What a ThesisProximity holds.
#pragma once

#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

namespace proxima {

struct PROXIMA_HIDDEN ThesisProximityParts {
    TriangleMesh mesh;
    Topology topology;
    ThesisProximityOctree octree;
};

} // namespace proxima
