#include "viewer/query_shapes.h"

#include "proxima/mesh_repair.h"

#include <algorithm>
#include <cmath>

namespace proxima {

std::vector<TriangleId> all_but(const TriangleMesh& mesh, std::span<const TriangleId> named)
{
    std::vector<TriangleId> rest;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i)
        if (!std::ranges::binary_search(named, TriangleId{i})) rest.push_back(TriangleId{i});
    return rest;
}

void add_part(DrawnScene& scene, const TriangleMesh& mesh, std::span<const TriangleId> triangles,
              const ShapeStyle& style)
{
    if (!triangles.empty()) add_mesh(scene, sub_mesh(mesh, triangles), style);
}

std::vector<Box> boxes_of_leaves(const Octree& octree, const std::vector<LeafPair>& pairs,
                                 Cell LeafPair::*side)
{
    std::vector<Cell> cells;
    std::vector<bool> is_seen(octree.nodes().size());
    for (const LeafPair& pair : pairs) {
        const Cell& cell = pair.*side;
        if (!is_seen[cell.node]) cells.push_back(cell);
        is_seen[cell.node] = true;
    }
    std::ranges::sort(cells, {}, &Cell::key);
    std::vector<Box> boxes;
    boxes.reserve(cells.size());
    for (const Cell& cell : cells) boxes.push_back(octree.box(cell));
    return boxes;
}

std::array<Vec3, 8> frustum_corners(const PerspectiveCamera& camera)
{
    const Vec3 forward = camera.forward.normalized();
    const Vec3 right = forward.cross(camera.up).normalized();
    const Vec3 up = right.cross(forward);
    const double slope = std::tan(0.5 * camera.field_of_view);
    std::array<Vec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i) {
        const double depth = i < 4 ? camera.near : camera.far;
        const double x = (i + 1) % 4 < 2 ? -1.0 : 1.0; // -1, 1, 1, -1
        const double y = i % 4 < 2 ? -1.0 : 1.0;       // -1, -1, 1, 1
        corners[i] = camera.eye + depth * (forward + slope * (camera.aspect * x * right + y * up));
    }
    return corners;
}

void add_frustum(DrawnScene& scene, const PerspectiveCamera& camera, const EdgeStyle& style)
{
    const auto corners = frustum_corners(camera);
    SceneLines lines{style.name, {}, style.color, style.width, style.opacity};
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t next = (i + 1) % 4;
        lines.segments.push_back({corners[i], corners[next]});
        lines.segments.push_back({corners[4 + i], corners[4 + next]});
        lines.segments.push_back({corners[i], corners[4 + i]});
        lines.segments.push_back({camera.eye, corners[i]});
    }
    scene.lines.push_back(std::move(lines));
}

Color intensity_color(double weight)
{
    // Even steps of weight look like even steps: the scale is that of sRGB, not of light.
    const double part = std::clamp(weight, 0.0, 1.0);
    const auto channel = [&](unsigned full) {
        return static_cast<unsigned>(std::lround(part * full));
    };
    return srgb(channel(0xFF) << 16U | channel(0xDC) << 8U | channel(0x2E));
}

double chord_weight(const Octree& octree, const CellOnRay& cell)
{
    // No chord is longer than the cell's diagonal.
    return cell.chord / octree.box(cell.cell).extent().norm();
}

std::vector<std::uint32_t> facets_of(const MinkowskiSum& sum, FacetOrigin origin)
{
    std::vector<std::uint32_t> facets;
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f)
        if (sum.facet(f).origin == origin) facets.push_back(f);
    return facets;
}

} // namespace proxima
