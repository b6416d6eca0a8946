#include "viewer/scene.h"

namespace proxima {

std::vector<Vec3> positions_of(const DrawnScene& scene)
{
    std::vector<Vec3> positions;
    for (const SceneSurface& surface : scene.surfaces)
        positions.insert(positions.end(), surface.positions.begin(), surface.positions.end());
    for (const SceneLines& lines : scene.lines) {
        for (const auto& segment : lines.segments)
            positions.insert(positions.end(), segment.begin(), segment.end());
    }
    return positions;
}

Box bounding_box(const DrawnScene& scene)
{
    Box box;
    for (const Vec3& position : positions_of(scene)) box.extend(position);
    return box;
}

} // namespace proxima
