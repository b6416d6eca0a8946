// A triangle that a proxy may meet.
#pragma once

#include "geometry/shapes.h"
#include "mesh/triangle_mesh.h"

namespace proxima {

struct ContactTriangle {
    Triangle corners;
    TriangleId id{};
};

} // namespace proxima
