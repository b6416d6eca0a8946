// The scene of a picture: an eye that sees all of it, lamps, and meshes shaded by them.
#pragma once

#include "cli/canvas.h"
#include "cli/octree_picture.h"
#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <functional>
#include <span>

namespace proxima {

/// Perspective view of a box, three-quarter from above.
class Camera {
public:
    Camera(const Box& box, UpAxis up);

    /// Moves and zooms so that all points fill the picture but for its margin.
    void fit(std::span<const Vec3> points, int width, int height);

    [[nodiscard]] const Vec3& eye() const noexcept { return eye_; }

    /// Direction on the screen (right, up, towards the eye) to one of the mesh.
    [[nodiscard]] Vec3 from_screen(const Vec3& direction) const noexcept
    {
        return direction.x() * right_ + direction.y() * up_ + direction.z() * back_;
    }

    [[nodiscard]] ScreenPoint project(const Vec3& point) const noexcept;

private:
    Vec3 center_;
    double scale_;
    Vec3 right_;
    Vec3 up_;
    Vec3 back_; // from the scene to the eye
    Vec3 eye_;
    double zoom_ = 1.0; // pixels
    Vec2 origin_ = Vec2::Zero();
};

/// The colour of a triangle's surface.
using SurfaceColor = std::function<Color(TriangleId)>;

/// Draws the mesh shaded, in the clay colour of all pictures unless colours are given. Stage "drawing the mesh".
void draw_mesh(Canvas& canvas, const Camera& camera, const TriangleMesh& mesh,
               const SurfaceColor& color, Progress* progress);

} // namespace proxima
