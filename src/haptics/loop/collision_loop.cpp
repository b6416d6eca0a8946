#include "haptics/loop/collision_loop.h"

#include <limits>

namespace proxima {

void make_patch(ContactPatch& patch, const IndexContactSurface& surface, const ServoPlace& place,
                const CollisionOptions& options) noexcept
{
    const double radius = patch_radius(options.speed, 1 / options.rate, options.latency_seconds,
                                       (place.device - place.proxy).norm(), options.proxy_radius);
    // A little more: what the proxy asks for beyond its radius is within a skin.
    fill_metric_patch(patch, surface, place.device, radius * (1 + 1e-6));
    patch.made_at = place.tick;
}

CollisionLoop::CollisionLoop(const IndexContactSurface& surface, PatchExchange& exchange,
                             const CollisionOptions& options)
    : thread_([this, &surface, &exchange, options] {
          statistics_ =
              run_servo_loop({.rate = options.rate,
                              .ticks = std::numeric_limits<std::uint64_t>::max(),
                              .pace = Pace::best_effort},
                             [&](std::uint64_t) noexcept {
                                 if (ending_.load()) return Flow::stop;
                                 ServoPlace place;
                                 if (exchange.hear(place)) {
                                     make_patch(exchange.writing(), surface, place, options);
                                     exchange.give();
                                     patches_.fetch_add(1);
                                 }
                                 return Flow::proceed;
                             });
      })
{}

const ServoStatistics& CollisionLoop::stop()
{
    ending_.store(true);
    if (thread_.joinable()) thread_.join();
    return statistics_;
}

CollisionLoop::~CollisionLoop()
{
    (void)stop();
}

} // namespace proxima
