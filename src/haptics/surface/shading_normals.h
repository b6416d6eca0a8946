// Normals that vary smoothly over a mesh, for force shading ([ruspini-1997]), like Phong normals for
// light.
//
//     corner    mean of the normals round a vertex, weighted by angle, of the triangles that are
//               joined there across edges that are not sharp
//     inside    corners' normals, weighted by barycentric coordinates
//
// So a coarse sphere feels round, and the edges of a cube stay edges.
#pragma once

#include "haptics/surface/surface_properties.h"
#include "proxima/topology.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <vector>

namespace proxima {

struct ShadingOptions {
    double sharp_angle = 0.75; ///< radians: edges where normals differ by more stay edges
};

/// Refers to the mesh, which must outlive it. Immutable; 72 bytes per triangle.
class ShadingNormals final : public SurfaceProperties {
public:
    /// O(triangles), and at each vertex the square of how many meet there. Edges of one triangle, or
    /// of more than two, are sharp. Triangles without an area have no weight.
    ShadingNormals(const TriangleMesh& mesh, const Topology& topology,
                   const ShadingOptions& options = {});

    /// Nothing: the renderer's own settings hold.
    [[nodiscard]] std::optional<SurfaceMaterial>
    material(TriangleId /*triangle*/) const noexcept override
    {
        return std::nullopt;
    }

    /// 30 ns.
    [[nodiscard]] Vec3 shaded_normal(TriangleId triangle,
                                     const Vec3& point) const noexcept override;

private:
    const TriangleMesh& mesh_;
    std::vector<std::array<Vec3, 3>> corners_; ///< by triangle
};

} // namespace proxima
