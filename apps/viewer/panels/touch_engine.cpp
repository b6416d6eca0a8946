#include "viewer/panels/touch_engine.h"

#include "base/text.h"
#include "haptics/force/surface_renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace proxima {
namespace {

RenderOptions render_options(const TouchOptions& options)
{
    RenderOptions render;
    render.force.stiffness = options.stiffness;
    render.force.damping = options.damping;
    render.static_friction = options.static_friction;
    render.dynamic_friction = std::min(options.dynamic_friction, options.static_friction);
    return render;
}

/// How often the loop runs and how late it is at worst.
class TickClock {
public:
    /// A tick begins.
    void tick(TouchMoment& moment) noexcept
    {
        constexpr std::uint64_t ticks_per_measure = 500;
        const auto now = Clock::now();
        worst_ = std::max(worst_, seconds(now - before_));
        before_ = now;
        if (++ticks_ % ticks_per_measure != 0) return;
        const double span = seconds(now - measured_);
        moment.rate = span > 0.0 ? static_cast<double>(ticks_per_measure) / span : 0.0;
        moment.worst_interval = worst_;
        measured_ = now;
        worst_ = 0.0;
    }

private:
    using Clock = std::chrono::steady_clock;

    static double seconds(Clock::duration span) noexcept
    {
        return std::chrono::duration<double>(span).count();
    }

    Clock::time_point before_ = Clock::now();
    Clock::time_point measured_ = before_;
    double worst_ = 0.0;
    std::uint64_t ticks_ = 0;
};

std::string words_of(const DeviceInfo& info)
{
    return concat(info.model.empty() ? info.name : info.model, info.serial.empty() ? "" : ", ",
                  info.serial);
}

} // namespace

TouchSession::TouchSession(const ContactSurface& surface, TouchDevice device,
                           const TouchOptions& options)
    : device_(std::move(device)),
      input_(make_device_input(device_.device->info(),
                               {.tick_seconds = tick_seconds, .rotation = options.axes})
                 .value()),
      renderer_(
          make_surface_renderer(surface, device_.map, device_.limits, render_options(options)))
{}

void TouchSession::tick() noexcept
{
    constexpr std::uint64_t ticks_per_value = 5;
    const DeviceState& said = input_.accept(device_.device->read());
    const RenderTick& rendered = renderer_.tick(said, tick_seconds);
    device_.device->write(input_.command(renderer_));
    moment_.condition = said.condition;
    moment_.buttons = said.buttons;
    moment_.placed = moment_.placed || said.pose.translation.allFinite();
    moment_.device = device_.map.to_model(rendered.position);
    moment_.proxy = rendered.hold == Hold::free ? moment_.device : rendered.proxy;
    moment_.force = rendered.force;
    moment_.hold = rendered.hold;
    if (moment_.ticks % ticks_per_value == 0) {
        std::shift_left(moment_.forces.begin(), moment_.forces.end(), 1);
        moment_.forces.back() = static_cast<float>(rendered.force.norm());
    }
    ++moment_.ticks;
}

TouchEngine::TouchEngine(const ContactSurface& surface, OpenTouchDevice open,
                         const TouchOptions& options)
    : thread_([this, &surface, open = std::move(open), options] { run(surface, open, options); })
{}

TouchEngine::~TouchEngine()
{
    stops_.store(true);
    thread_.join();
}

const TouchMoment& TouchEngine::moment()
{
    moments_.update();
    return moments_.reading();
}

TouchDeviceState TouchEngine::device() const
{
    const std::scoped_lock lock(mutex_);
    return state_;
}

void TouchEngine::say(TouchDeviceState state)
{
    const std::scoped_lock lock(mutex_);
    state_ = std::move(state);
}

void TouchEngine::run(const ContactSurface& surface, const OpenTouchDevice& open,
                      const TouchOptions& options)
{
    constexpr std::uint64_t ticks_per_moment = 8;
    auto opened = open();
    if (!opened) {
        say({{}, describe(opened.error())});
        return;
    }
    TouchSession session(surface, std::move(*opened), options);
    const DeviceInfo& info = session.device().info();
    say({words_of(info), {}});
    // Nobody's hand is let go of suddenly.
    const double fading = info.pushes ? RenderOptions{}.force.loss_seconds : 0.0;
    auto left = static_cast<std::uint64_t>(std::ceil(fading / TouchSession::tick_seconds)) + 1;
    TickClock clock;
    (void)session.device().run({.rate = 1.0 / TouchSession::tick_seconds,
                                .ticks = std::numeric_limits<std::uint64_t>::max(),
                                .pace = Pace::best_effort},
                               [&](std::uint64_t /*number*/) noexcept {
                                   const bool stops = stops_.load(std::memory_order_relaxed);
                                   if (stops) session.release();
                                   clock.tick(session.moment());
                                   session.tick();
                                   if (session.moment().ticks % ticks_per_moment == 0) {
                                       moments_.writing() = session.moment();
                                       moments_.publish();
                                   }
                                   return stops && --left == 0 ? Flow::stop : Flow::proceed;
                               });
    if (stops_.load()) return;
    // The driver ended it.
    const std::string trouble = session.device().trouble();
    say({{}, trouble.empty() ? "the device's driver ended the session" : trouble});
}

} // namespace proxima
