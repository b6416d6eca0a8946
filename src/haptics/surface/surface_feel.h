// What a surface is like beyond its shape: how stiff and rough it is, and which way it seems to
// face. Asked by triangle, where something touches.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <optional>

namespace proxima {

/// Of an object. Limited by what the device can take.
struct SurfaceMaterial {
    double stiffness = 500;        ///< K, N/m
    double damping = 1;            ///< B, N s/m
    double static_friction = 0.4;  ///< mu_s
    double dynamic_friction = 0.3; ///< mu_d, at most mu_s
};

/// Whether forces lean towards the normals of the smooth surface that a mesh stands for.
enum class ForceShading : bool { off, on };

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
