// What a sphere touches where it is: contacts with faces, sides and corners, each once.
#pragma once

#include "geometry/closest_point.h"
#include "haptics/proxy/contact_cache.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/geometry.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima {

/// A place at which the sphere touches.
struct Contact {
    Vec3 normal = Vec3::UnitZ(); ///< from the surface to the centre, of length 1
    Vec3 point = Vec3::Zero();   ///< of the triangle
    TriangleId triangle{};       ///< the lowest that is touched there
    TrianglePart part = TrianglePart::inside;
    Vec3 side = Vec3::Zero(); ///< the direction of the side that is touched, if one is
    double pressure = 0;      ///< part of the spring's force along the normal, over its stiffness
};

/// The touching point as a plane, or nothing where the triangle is beyond `limit`. What is aside of
/// the inside by no more than `rounding` counts as inside.
[[nodiscard]] std::optional<Contact> contact_with(const ContactTriangle& triangle, const Vec3& p,
                                                  double limit, double rounding) noexcept;

/// Of one place at a time; the last one is kept, for it is asked for again. All but the constructor
/// are noexcept, without allocation.
class TouchedPlaces {
public:
    TouchedPlaces();

    /// Nothing is touched.
    void clear() noexcept;

    /// Finds what is within `limit` of p; contacts no farther apart than `rounding` are one. False
    /// where there are more than there is room for. `near` is room for triangles.
    [[nodiscard]] bool find(ContactCache& cache, const ContactSurface& surface, const Vec3& p,
                            double limit, double rounding,
                            std::span<ContactTriangle> near) noexcept;

    /// The same of triangles that are known: all within `limit` of p, and any others.
    [[nodiscard]] bool find_among(std::span<const ContactTriangle> near,
                                  const ContactSurface& surface, const Vec3& p, double limit,
                                  double rounding) noexcept;

    /// By triangle id; contacts of several triangles at the same vertex or edge once.
    [[nodiscard]] std::span<const Contact> contacts() const noexcept
    {
        return std::span(contacts_).first(count_);
    }

    /// Whether the triangle is touched.
    [[nodiscard]] bool has(TriangleId id) const noexcept;

private:
    [[nodiscard]] bool is_known(const ContactSurface& surface, const Vec3& p,
                                double limit) const noexcept;
    [[nodiscard]] bool add(const Contact& contact, double rounding) noexcept;
    void drop_covered(const Vec3& p, double least) noexcept;

    std::vector<Contact> contacts_;
    std::vector<Contact> touched_; ///< of each triangle, by id
    std::size_t count_ = 0;
    std::size_t touched_count_ = 0;
    Vec3 at_ = Vec3::Zero();
    double limit_ = 0;
    std::uint64_t edition_ = 0; ///< of the surface that this was found of; 0 says none
};

} // namespace proxima
