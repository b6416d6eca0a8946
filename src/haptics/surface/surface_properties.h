// Properties of a surface beside its shape: material, texture and smooth normals, by triangle.
#pragma once

#include "proxima/geometry.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <optional>

namespace proxima {

/// All members are noexcept, do not allocate, and may be called from any thread.
class SurfaceProperties {
public:
    SurfaceProperties() = default;
    SurfaceProperties(const SurfaceProperties&) = delete;
    SurfaceProperties& operator=(const SurfaceProperties&) = delete;
    virtual ~SurfaceProperties() = default;

    /// Material of a triangle; nothing where the renderer's own settings hold.
    [[nodiscard]] virtual std::optional<SurfaceMaterial>
    material(TriangleId triangle) const noexcept = 0;

    /// Normal of the smooth surface at a point of the triangle, of length 1, to the side that the
    /// triangle faces; zero where the surface is not smooth. \pre the point is on the triangle
    [[nodiscard]] virtual Vec3 shaded_normal(TriangleId triangle,
                                             const Vec3& point) const noexcept = 0;

    /// Texture of a triangle; null where the renderer's own holds.
    [[nodiscard]] virtual const SurfaceTexture* texture(TriangleId /*triangle*/) const noexcept
    {
        return nullptr;
    }

    /// From the frame of a triangle's object, to which textures belong, to that of the surface.
    [[nodiscard]] virtual RigidTransform pose(TriangleId /*triangle*/) const noexcept { return {}; }
};

} // namespace proxima
