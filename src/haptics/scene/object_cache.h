// Caches the near triangles of one object of a scene in the object's own frame.
//
//     own frame       relative to the object a proxy that touches it moves slowly, so the balls of
//                     contact_cache.h stay valid although everything moves in the scene's frame
//     several balls   queries alternate between the proxy, which lags behind by friction, the
//                     frictionless position, and the positions of both in the last tick
#pragma once

#include "haptics/proxy/contact_cache.h"
#include "haptics/surface/contact_surface.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace proxima {

/// One thread; 154 KB. Positions are in the object's frame. All but the constructor are noexcept and
/// do not allocate.
class ObjectCache {
public:
    /// Like surface.collect_along().
    [[nodiscard]] std::size_t collect_along(const ContactSurface& surface, const Vec3& p,
                                            const Vec3& motion, double distance,
                                            std::span<ContactTriangle> buffer) noexcept;

    /// Like surface.clearance_beyond().
    [[nodiscard]] double clearance(const ContactSurface& surface, const Vec3& p,
                                   double wanted) noexcept
    {
        return balls_.front().clearance(surface, p, wanted);
    }

    /// A lower bound of the surface's distance without a query of it; negative where none is known.
    [[nodiscard]] double known_clearance(const ContactSurface& surface, const Vec3& p) noexcept
    {
        return balls_.front().known_clearance(surface, p);
    }

    [[nodiscard]] ContactWork work() const noexcept;

private:
    static constexpr std::size_t ball_count = 3;

    std::array<ContactCache, ball_count> balls_;
    std::array<std::uint64_t, ball_count> last_use_{}; ///< of each ball, in queries
    std::uint64_t queries_ = 0;
};

} // namespace proxima
