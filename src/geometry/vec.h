// Vectors of the house: Eigen's, under our names.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace proxima {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

} // namespace proxima
