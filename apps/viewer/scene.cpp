#include "viewer/scene.h"

namespace proxima {

std::vector<Vec3> places_of(const Scene& scene)
{
    std::vector<Vec3> places;
    for (const SceneSurface& surface : scene.surfaces)
        places.insert(places.end(), surface.positions.begin(), surface.positions.end());
    for (const SceneLines& lines : scene.lines)
        for (const auto& segment : lines.segments)
            places.insert(places.end(), segment.begin(), segment.end());
    return places;
}

Box bounding_box(const Scene& scene)
{
    Box box;
    for (const Vec3& place : places_of(scene)) box.extend(place);
    return box;
}

} // namespace proxima
