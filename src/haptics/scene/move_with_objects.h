// Takes a proxy along when objects move: from one tick's places of the objects to the next's.
//
//     goal     where the proxy would be: carried by what it touches, or where it was
//     seen     by each object, the proxy goes straight from where it stood to where it ends
//     touch    what an object's way would hit first becomes a plane that moved with the object
//     repeat   until no object is passed: the place nearest to the goal that all planes allow
//
// Every object, still or moving, holds the proxy back by its own motion relative to it: a plate
// that flies at the proxy pushes it, however thin and fast, and two that move differently form the
// corner that they form. Where they leave no room between them there is no such place.
#pragma once

#include "haptics/proxy/contact_planes.h"
#include "haptics/proxy/slide_sphere.h"
#include "haptics/scene/moving_surface.h"
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
    static constexpr std::size_t triangles = 8192; ///< of an object, near a way

    CarryScratch() : near_(triangles) {}

private:
    friend class Carry;
    /// A triangle's side that the sphere is on, in the object's frame.
    struct Side {
        TriangleId triangle{};
        Vec3 normal = Vec3::UnitZ();
        Vec3 point = Vec3::Zero();
        double distance = 0;
    };

    std::vector<ContactTriangle> near_;
    std::array<ContactPlane, max_contact_planes> planes_;
    std::array<TriangleId, max_contact_planes> walls_;
    std::array<Side, max_contact_planes> touched_;
};

/// Where a sphere ends that would go to `goal` while the objects go from where they stood to where
/// they are; nothing where they leave it no room, or more planes or triangles are near than there
/// is room for. noexcept, no allocation; half a microsecond per object nearby.
/// \pre where the objects stood, nothing was nearer to `from` than the radius, up to a skin;
/// radius >= safety_gap(scene.scale()); all finite
[[nodiscard]] std::optional<Vec3> move_with_objects(const MovingSurface& scene, double radius,
                                                    const Vec3& from, const Vec3& goal,
                                                    CarryScratch& scratch) noexcept;

/// Where a proxy that is held by these contacts goes with the objects that move: each carries it
/// by its part of the pressure.
[[nodiscard]] Vec3 carried_place(const MovingSurface& scene, std::span<const Contact> contacts,
                                 const Vec3& p) noexcept;

} // namespace proxima
