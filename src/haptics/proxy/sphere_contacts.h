// The contacts of a resting sphere with faces, sides and corners, each once.
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

/// A point at which the sphere touches.
struct Contact {
    Vec3 normal = Vec3::UnitZ(); ///< from the surface to the centre, of length 1
    Vec3 point = Vec3::Zero();   ///< on the triangle
    TriangleId triangle{};       ///< the lowest that is touched there
    TrianglePart part = TrianglePart::inside;
    Vec3 side = Vec3::Zero(); ///< the direction of the side that is touched, if one is
    double pressure = 0;      ///< part of the spring's force along the normal, over its stiffness
};

/// The contact of a triangle, or nothing where it is beyond `limit`. A point beside the triangle's
/// inside by no more than `rounding` counts as inside.
[[nodiscard]] std::optional<Contact> contact_with(const ContactTriangle& triangle, const Vec3& p,
                                                  double limit, double rounding) noexcept;

/// The contacts at one position, cached until another one is given. All but the constructor are
/// noexcept, without allocation.
class SphereContacts {
public:
    SphereContacts();

    /// Removes all contacts.
    void clear() noexcept;

    /// Finds the contacts within `limit` of p; those no farther apart than `rounding` are one. False
    /// where there are too many. `near` is scratch memory.
    [[nodiscard]] bool find(ContactCache& cache, const ContactSurface& surface, const Vec3& p,
                            double limit, double rounding,
                            std::span<ContactTriangle> near) noexcept;

    /// Like find(), among triangles that have all within `limit` of p.
    [[nodiscard]] bool find_among(std::span<const ContactTriangle> near,
                                  const ContactSurface& surface, const Vec3& p, double limit,
                                  double rounding) noexcept;

    /// In the order of triangle ids; contacts of several triangles at one vertex or edge once.
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
    std::vector<Contact> touched_; ///< one for each triangle, by id
    std::size_t count_ = 0;
    std::size_t touched_count_ = 0;
    Vec3 position_ = Vec3::Zero();
    double limit_ = 0;
    std::uint64_t edition_ = 0; ///< of the surface that these contacts are with; 0 for none
};

} // namespace proxima
