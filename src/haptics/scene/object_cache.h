// What is near on one object of a scene, kept in the object's own frame from tick to tick.
//
//     seen by the object   who touches it, or flies past, goes slowly: the balls of contact_cache.h
//                          hold though everything moves in the scene's frame
//     several balls        a proxy that lags behind by friction, the place without friction and
//                          where they were are asked about in turn
#pragma once

#include "haptics/proxy/contact_cache.h"
#include "haptics/surface/contact_surface.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// Of a thread; 154 KB. All places are in the object's frame. All but the constructor are noexcept
/// and do not allocate.
class ObjectCache {
public:
    /// As surface.collect_along(): all triangles that come within the distance of the way, and
    /// perhaps some that do not.
    [[nodiscard]] std::size_t collect_along(const ContactSurface& surface, const Vec3& p,
                                            const Vec3& way, double distance,
                                            std::span<ContactTriangle> buffer) noexcept;

    /// As surface.clearance_beyond().
    [[nodiscard]] double clearance(const ContactSurface& surface, const Vec3& p,
                                   double wanted) noexcept
    {
        return balls_.front().clearance(surface, p, wanted);
    }

    /// No part of the surface is nearer to p than this, as is known without asking. Negative where
    /// nothing is.
    [[nodiscard]] double known_clearance(const ContactSurface& surface, const Vec3& p) noexcept
    {
        return balls_.front().known_clearance(surface, p);
    }

    [[nodiscard]] ContactWork work() const noexcept;

private:
    static constexpr std::size_t ball_count = 3;

    std::array<ContactCache, ball_count> balls_;
    std::array<std::uint64_t, ball_count> last_use_{}; ///< of each ball, in questions
    std::uint64_t questions_ = 0;
};

} // namespace proxima
