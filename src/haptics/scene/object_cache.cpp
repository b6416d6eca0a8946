#include "haptics/scene/object_cache.h"

namespace proxima {

std::size_t ObjectCache::collect_along(const ContactSurface& surface, const Vec3& p,
                                       const Vec3& motion, double distance,
                                       std::span<ContactTriangle> buffer) noexcept
{
    const Vec3 middle = p + 0.5 * motion;
    const double around = distance + 0.5 * motion.norm();
    // Use a ball that covers the motion, else the one that was used longest ago.
    std::size_t best = 0;
    for (std::size_t i = 0; i < ball_count; ++i) {
        if (balls_[i].covers(surface, middle, around)) {
            best = i;
            break;
        }
        if (last_use_[i] < last_use_[best]) best = i;
    }
    last_use_[best] = ++queries_;
    return balls_[best].collect_along(surface, p, motion, distance, buffer);
}

ContactWork ObjectCache::work() const noexcept
{
    ContactWork sum;
    for (const ContactCache& ball : balls_) sum = sum + ball.work();
    return sum;
}

} // namespace proxima
