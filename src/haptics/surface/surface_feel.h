// What a surface is like beyond its shape: how stiff and rough it is, and which way it seems to
// face. Asked by triangle, where something touches.
#pragma once

#include "proxima/geometry.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <optional>

namespace proxima {

/// Asked by a proxy and its renderer. All members are noexcept, do not allocate, and may be called
/// from any thread.
class SurfaceFeel {
public:
    SurfaceFeel() = default;
    SurfaceFeel(const SurfaceFeel&) = delete;
    SurfaceFeel& operator=(const SurfaceFeel&) = delete;
    virtual ~SurfaceFeel() = default;

    /// Nothing where the renderer's own settings are meant.
    [[nodiscard]] virtual std::optional<SurfaceMaterial>
    material(TriangleId triangle) const noexcept = 0;

    /// The smooth surface's normal at a point of the triangle, of length 1, to the side that the
    /// triangle faces; zero where the surface is not smooth. \pre the point is on the triangle
    [[nodiscard]] virtual Vec3 shaded_normal(TriangleId triangle,
                                             const Vec3& point) const noexcept = 0;
};

} // namespace proxima
