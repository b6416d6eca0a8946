// A triangle that a proxy may meet.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

namespace proxima {

struct ContactTriangle {
    Triangle corners;
    TriangleId id{};
};

} // namespace proxima
