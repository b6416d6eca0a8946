#include "haptics/loop/collision_loop.h"

#include <limits>

namespace proxima {

void make_patch(ContactPatch& patch, const IndexContactSurface& surface,
                const ServoPosition& position, const CollisionOptions& options) noexcept
{
    const double radius =
        patch_radius(options.speed, 1 / options.rate, options.latency_seconds,
                     (position.device - position.proxy).norm(), options.proxy_radius);
    // A little more, for the proxy queries a skin beyond its radius.
    fill_metric_patch(patch, surface, position.device, radius * (1 + 1e-6));
    patch.made_at = position.tick;
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
                                 ServoPosition position;
                                 if (exchange.receive_position(position)) {
                                     make_patch(exchange.writing(), surface, position, options);
                                     exchange.publish_patch();
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
