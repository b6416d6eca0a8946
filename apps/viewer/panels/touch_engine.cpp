#include "viewer/panels/touch_engine.h"

#include "proxima/haptics/servo_loop.h"

#include <algorithm>
#include <chrono>
#include <limits>

namespace proxima {
namespace {

DeviceLimits limits()
{
    return find_device("touch").value_or(DeviceLimits{});
}

RenderOptions render_options(const TouchOptions& options)
{
    RenderOptions render;
    render.force.stiffness = options.stiffness;
    render.force.damping = options.damping;
    render.static_friction = options.static_friction;
    render.dynamic_friction = std::min(options.dynamic_friction, options.static_friction);
    return render;
}

} // namespace

TouchSimulation::TouchSimulation(const ContactSurface& surface, const Box& bounds,
                                 const TouchOptions& options, const Vec3& start)
    : map_(fit_workspace(bounds, limits().workspace_radius)),
      renderer_(surface, map_, limits(), render_options(options)),
      hand_({.tick_seconds = tick_seconds}, map_.to_device(start))
{
    moment_.device = moment_.proxy = start;
}

void TouchSimulation::tick(const Vec3& target) noexcept
{
    constexpr std::uint64_t ticks_per_value = 5;
    const RenderTick& felt = renderer_.tick(hand_.state(), tick_seconds);
    moment_.device = map_.to_model(felt.position);
    moment_.proxy = felt.proxy.hold == Hold::free ? moment_.device : felt.proxy.proxy;
    moment_.force = felt.force;
    moment_.hold = felt.proxy.hold;
    if (moment_.ticks % ticks_per_value == 0) {
        std::shift_left(moment_.forces.begin(), moment_.forces.end(), 1);
        moment_.forces.back() = static_cast<float>(felt.force.norm());
    }
    ++moment_.ticks;
    hand_.step(felt.force, map_.to_device(target));
}

TouchEngine::TouchEngine(const ContactSurface& surface, const Box& bounds,
                         const TouchOptions& options, const Vec3& start)
    : simulation_(surface, bounds, options, start), target_(start), thread_([this] { run(); })
{}

TouchEngine::~TouchEngine()
{
    stops_.store(true);
    thread_.join();
}

void TouchEngine::pull_to(const Vec3& target)
{
    target_.writing() = target;
    target_.publish();
}

const TouchMoment& TouchEngine::moment()
{
    moments_.update();
    return moments_.reading();
}

void TouchEngine::run() noexcept
{
    using Clock = std::chrono::steady_clock;
    constexpr std::uint64_t ticks_per_moment = 8;
    constexpr std::uint64_t ticks_per_measure = 500;
    auto before = Clock::now();
    auto measured = before;
    double worst = 0.0;
    (void)run_servo_loop(
        {.rate = 1.0 / TouchSimulation::tick_seconds,
         .ticks = std::numeric_limits<std::uint64_t>::max(),
         .pace = Pace::best_effort},
        [&](std::uint64_t /*number*/) noexcept {
            const auto now = Clock::now();
            worst = std::max(worst, std::chrono::duration<double>(now - before).count());
            before = now;
            target_.update();
            simulation_.tick(target_.reading());
            TouchMoment& moment = simulation_.moment();
            if (moment.ticks % ticks_per_measure == 0) {
                const double span = std::chrono::duration<double>(now - measured).count();
                moment.rate = span > 0.0 ? static_cast<double>(ticks_per_measure) / span : 0.0;
                moment.worst_interval = worst;
                measured = now;
                worst = 0.0;
            }
            if (moment.ticks % ticks_per_moment == 0) {
                moments_.writing() = moment;
                moments_.publish();
            }
            return stops_.load(std::memory_order_relaxed) ? Flow::stop : Flow::proceed;
        });
}

} // namespace proxima
