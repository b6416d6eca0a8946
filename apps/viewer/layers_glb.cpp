#include "viewer/layers_glb.h"

#include "base/progress.h"
#include "mesh/io/glb_file.h"

#include <algorithm>

namespace proxima {
namespace {

std::array<double, 3> linear_channels(const Color& color)
{
    std::array<double, 3> channels{};
    for (std::size_t k = 0; k < 3; ++k)
        channels[k] = std::clamp(static_cast<double>(color[static_cast<int>(k)]), 0.0, 1.0);
    return channels;
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
        GlbPart part;
        part.name = surface.name;
        part.colour = linear_channels(surface.color);
        for (const Vec3& position : surface.positions) part.add_point(position, origin);
        for (const TriangleCorners& corners : surface.triangles)
            part.indices.insert(part.indices.end(), corners.begin(), corners.end());
        parts.push_back(std::move(part));
        if (!steps.done(1)) return cancelled("the export");
    }
    for (const SceneLines& lines : scene.lines) {
        GlbPart part;
        part.name = lines.name;
        part.mode = GlbPart::Mode::lines;
        part.colour = linear_channels(lines.color);
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
