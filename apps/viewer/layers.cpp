#include "viewer/layers.h"

#include <algorithm>

namespace proxima {
namespace {

/// How far outside a position is, negative inside.
double beyond(const HalfSpace& cut, const Vec3& position)
{
    return cut.normal.dot(position) - cut.offset;
}

/// Triangles cut at the plane: those that cross it become one or two smaller ones.
SceneSurface cut_surface(const SceneSurface& from, const HalfSpace& cut)
{
    SceneSurface result = from;
    result.triangles.clear();
    for (const TriangleCorners& triangle : from.triangles) {
        std::vector<std::uint32_t> kept;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t here = triangle[k];
            const std::uint32_t next = triangle[(k + 1) % 3];
            const double at = beyond(cut, from.positions[here]);
            const double after = beyond(cut, from.positions[next]);
            if (at <= 0.0) kept.push_back(here);
            if ((at <= 0.0) == (after <= 0.0)) continue;
            const double part = at / (at - after);
            kept.push_back(static_cast<std::uint32_t>(result.positions.size()));
            result.positions.emplace_back((1.0 - part) * from.positions[here] +
                                          part * from.positions[next]);
            if (!from.normals.empty()) {
                const Vec3 normal = (1.0 - part) * from.normals[here] + part * from.normals[next];
                result.normals.emplace_back(normal.stableNormalized());
            }
        }
        for (std::size_t i = 2; i < kept.size(); ++i)
            result.triangles.push_back({kept[0], kept[i - 1], kept[i]});
    }
    return result;
}

SceneLines cut_lines(const SceneLines& from, const HalfSpace& cut)
{
    SceneLines result = from;
    result.segments.clear();
    for (auto segment : from.segments) {
        const double at = beyond(cut, segment[0]);
        const double after = beyond(cut, segment[1]);
        if (at > 0.0 && after > 0.0) continue;
        if ((at <= 0.0) != (after <= 0.0)) {
            const double part = at / (at - after);
            const Vec3 middle = (1.0 - part) * segment[0] + part * segment[1];
            segment[at > 0.0 ? 0 : 1] = middle;
        }
        result.segments.push_back(segment);
    }
    return result;
}

void append(DrawnScene& scene, const SceneLayer& layer)
{
    for (SceneSurface surface : layer.scene->surfaces) {
        for (Vec3& position : surface.positions) position = layer.pose(position);
        for (Vec3& normal : surface.normals) normal = layer.pose.rotation * normal;
        if (layer.color) surface.color = *layer.color;
        surface.opacity *= layer.opacity;
        scene.surfaces.push_back(layer.cut ? cut_surface(surface, *layer.cut) : std::move(surface));
    }
    for (SceneLines lines : layer.scene->lines) {
        for (auto& segment : lines.segments)
            for (Vec3& end : segment) end = layer.pose(end);
        lines.opacity *= layer.opacity;
        scene.lines.push_back(layer.cut ? cut_lines(lines, *layer.cut) : std::move(lines));
    }
}

} // namespace

DrawnScene flattened(std::span<const SceneLayer> layers, const Backdrop& backdrop)
{
    DrawnScene scene;
    scene.background_top = backdrop.top;
    scene.background_bottom = backdrop.bottom;
    for (const SceneLayer& layer : layers) append(scene, layer);
    return scene;
}

Box bounding_box(std::span<const SceneLayer> layers)
{
    Box box;
    for (const SceneLayer& layer : layers) {
        for (const SceneSurface& surface : layer.scene->surfaces)
            for (const Vec3& position : surface.positions) box.extend(layer.pose(position));
        for (const SceneLines& lines : layer.scene->lines) {
            for (const auto& segment : lines.segments)
                for (const Vec3& position : segment) box.extend(layer.pose(position));
        }
    }
    return box;
}

} // namespace proxima
