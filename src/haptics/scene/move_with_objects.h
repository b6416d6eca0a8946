// Moves a proxy when objects move, from their poses of one tick to those of the next.
//
//     goal      where the proxy would be: carried by the objects that it touches, or where it was
//     path      in each object's frame the proxy moves straight from its old position to the new one
//     contact   the first triangle on that path becomes a plane that moves with the object
//     repeat    until no object is passed: the position nearest to the goal that all planes allow
//
// Triangles of an object whose shape changes move in its frame as well; planes then separate the
// proxy from them for the whole motion (moving_triangle.h).
//
// Every object, at rest or moving, limits the proxy's motion relative to it: a plate that flies at
// the proxy pushes it, however thin and fast, and two objects that move differently form a corner.
// Where objects squeeze the proxy there is no such position.
#pragma once

#include "haptics/proxy/contact_planes.h"
#include "haptics/proxy/slide_sphere.h"
#include "haptics/scene/moving_surface.h"
#include "haptics/surface/moving_triangle.h"
#include "proxima/geometry.h"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// Memory for it, allocated once; one per thread.
class CarryScratch {
public:
    static constexpr std::size_t triangles = 8192;          ///< capacity, of an object near a path
    static constexpr std::size_t changing_triangles = 2048; ///< of one whose shape changes

    CarryScratch() : near_(triangles), changing_(changing_triangles) {}

private:
    friend class Carry;
    /// The side of a triangle on which the sphere is, in the object's frame.
    struct Side {
        TriangleId triangle{};
        Vec3 normal = Vec3::UnitZ();
        Vec3 point = Vec3::Zero();
        double distance = 0;
    };

    std::vector<ContactTriangle> near_;
    std::vector<MovingTriangle> changing_;
    std::array<ContactPlane, max_contact_planes> planes_;
    std::array<TriangleId, max_contact_planes> walls_;
    std::array<Side, max_contact_planes> touched_;
};

/// The end of a sphere's motion towards `goal` during the objects' last motion; nothing where they
/// squeeze it, or more planes or triangles are near than the capacity. noexcept, no allocation; half
/// a microsecond per object nearby. \pre before the motion nothing was nearer to `from` than the
/// radius, up to a skin; radius >= safety_gap(scene.scale()); all finite
[[nodiscard]] std::optional<Vec3> move_with_objects(const MovingSurface& scene, double radius,
                                                    const Vec3& from, const Vec3& goal,
                                                    CarryScratch& scratch) noexcept;

/// Where moving objects carry a proxy.
struct CarriedGoal {
    Vec3 position = Vec3::Zero();
    double way = 0;    ///< from where the proxy was
    double spread = 0; ///< no contact alone would carry it farther from there than this
};

/// The position to which moving objects carry a proxy with these contacts, each by its part of the
/// pressure. An object whose shape changes carries it with the nearest triangle, and onto it.
[[nodiscard]] CarriedGoal carried_position(const MovingSurface& scene, double radius,
                                           std::span<const Contact> contacts, const Vec3& p,
                                           CarryScratch& scratch) noexcept;

} // namespace proxima
