#include "viewer/layers_glb.h"

#include "base/progress.h"
#include "mesh/io/glb_file.h"

#include <algorithm>

namespace proxima {
namespace {

double in_unit_range(float value)
{
    return std::clamp(static_cast<double>(value), 0.0, 1.0);
}

/// A part with name, colour and opacity of a surface or of lines.
template <class Drawn>
GlbPart part_like(const Drawn& drawn)
{
    GlbPart part;
    part.name = drawn.name;
    for (std::size_t k = 0; k < 3; ++k)
        part.colour[k] = in_unit_range(drawn.color[static_cast<int>(k)]);
    part.opacity = in_unit_range(drawn.opacity);
    return part;
}

} // namespace

Status export_scene(const DrawnScene& scene, const std::filesystem::path& path, Progress* progress)
{
    const Box box = bounding_box(scene);
    const Vec3 origin = box.empty() ? Vec3(Vec3::Zero()) : box.center();
    std::vector<GlbPart> parts;
    StageSteps steps(progress, "collecting what is shown",
                     scene.surfaces.size() + scene.lines.size(), 1);
    for (const SceneSurface& surface : scene.surfaces) {
        GlbPart part = part_like(surface);
        for (const Vec3& position : surface.positions) part.add_point(position, origin);
        for (const TriangleCorners& corners : surface.triangles)
            part.indices.insert(part.indices.end(), corners.begin(), corners.end());
        parts.push_back(std::move(part));
        if (!steps.done(1)) return cancelled("the export");
    }
    for (const SceneLines& lines : scene.lines) {
        GlbPart part = part_like(lines);
        part.mode = GlbPart::Mode::lines;
        for (const auto& segment : lines.segments) {
            for (const Vec3& end : segment) {
                part.indices.push_back(static_cast<std::uint32_t>(part.points.size()));
                part.add_point(end, origin);
            }
        }
        parts.push_back(std::move(part));
        if (!steps.done(1)) return cancelled("the export");
    }
    return write_glb(parts, origin, path, progress);
}

} // namespace proxima
