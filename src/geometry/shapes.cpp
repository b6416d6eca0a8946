#include "proxima/geometry.h"

namespace proxima {

Box bounding_box(const Triangle& triangle) noexcept
{
    Box box;
    for (const Vec3& vertex : triangle.vertices) box.extend(vertex);
    return box;
}

Vec3 scaled_normal(const Triangle& triangle) noexcept
{
    return (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
}

} // namespace proxima
