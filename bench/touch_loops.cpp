#include "touch_loops.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/surface/contact_surface.h"
#include "lab/hand_script.h"
#include "lab/quality_report.h"
#include "lab/simulated_hand.h"
#include "proxima/cast_ray.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "touch_model.h"
#include "touch_track.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <thread>
#include <vector>

namespace proxima::bench {

namespace {

constexpr double graphics_rate = 50;
constexpr int picture_width = 200;
constexpr int picture_height = 150;

/// Pictures of the model by a ray per pixel, from a camera that goes round it.
class GraphicsLoop {
public:
    GraphicsLoop(const MeshIndex& index, const Box& box)
        : index_(index), center_(box.center()), size_(box.extent().norm()),
          pixels_(std::size_t{picture_width} * picture_height), thread_([this] {
              statistics_ = run_servo_loop({.rate = graphics_rate,
                                            .ticks = std::numeric_limits<std::uint64_t>::max(),
                                            .pace = Pace::best_effort},
                                           [this](std::uint64_t frame) noexcept {
                                               if (ending_.load()) return Flow::stop;
                                               draw(frame);
                                               return Flow::proceed;
                                           });
          })
    {}

    const ServoStatistics& stop()
    {
        ending_.store(true);
        if (thread_.joinable()) thread_.join();
        return statistics_;
    }
    GraphicsLoop(const GraphicsLoop&) = delete;
    GraphicsLoop& operator=(const GraphicsLoop&) = delete;
    ~GraphicsLoop() { (void)stop(); }

private:
    void draw(std::uint64_t frame) noexcept
    {
        const double turn = 0.02 * static_cast<double>(frame);
        const Vec3 ahead = -Vec3(std::cos(turn), 0.2, std::sin(turn)).normalized();
        const Vec3 right = ahead.cross(Vec3::UnitY()).normalized();
        const Vec3 up = right.cross(ahead);
        const Vec3 eye = center_ - 1.2 * size_ * ahead;
        for (int y = 0; y < picture_height; ++y) {
            for (int x = 0; x < picture_width; ++x) {
                const double across = (x + 0.5) / picture_width - 0.5;
                const double along =
                    (0.5 - (y + 0.5) / picture_height) * picture_height / picture_width;
                Ray ray;
                ray.origin = eye;
                ray.direction = ahead + across * right + along * up;
                const auto hit = closest_hit(index_, ray);
                pixels_[static_cast<std::size_t>(y) * picture_width + static_cast<std::size_t>(x)] =
                    hit ? static_cast<float>(hit->t) : 0.0F;
            }
        }
    }

    const MeshIndex& index_;
    Vec3 center_;
    double size_;
    std::vector<float> pixels_;
    std::atomic<bool> ending_{false};
    ServoStatistics statistics_;
    std::thread thread_;
};

double microseconds(std::uint64_t nanoseconds)
{
    return 1e-3 * static_cast<double>(nanoseconds);
}

void print_quantiles(const char* what, const LatencyHistogram& histogram)
{
    std::printf("  %-34s p50 %8.2f  p99 %8.2f  p99.9 %8.2f  p99.99 %8.2f  max %8.2f us\n", what,
                microseconds(histogram.quantile(0.5)), microseconds(histogram.quantile(0.99)),
                microseconds(histogram.quantile(0.999)), microseconds(histogram.quantile(0.9999)),
                microseconds(histogram.max()));
}

void print_histogram(const char* what, const LatencyHistogram& histogram)
{
    std::printf("  %s, by powers of two\n", what);
    for (std::uint64_t top = 256; histogram.count_below(top / 2) < histogram.count(); top *= 2) {
        const std::uint64_t low = top == 256 ? 0 : top / 2;
        const std::uint64_t count =
            histogram.count_below(top) - (low == 0 ? 0 : histogram.count_below(low));
        if (count == 0) continue;
        const double part = static_cast<double>(count) / static_cast<double>(histogram.count());
        const auto bar = static_cast<int>(std::ceil(50 * part));
        std::printf("  %9.3f to %9.3f us %9llu  %.*s\n", microseconds(low), microseconds(top),
                    static_cast<unsigned long long>(count), bar,
                    "##################################################");
    }
}

unsigned long long printable(std::uint64_t number)
{
    return number;
}

double percent(std::uint64_t part, std::uint64_t whole)
{
    return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

/// What the thread ran, without what held it up: other programs, the system, a machine about it.
std::int64_t processor_time() noexcept
{
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

/// A tick, from what the device says to the force.
struct TimedTick {
    std::uint64_t number = 0;
    std::uint64_t took = 0; ///< ns by the clock
    std::uint64_t ran = 0;  ///< ns of these that its thread was running
    int moves = 0;          ///< of the proxy
};

/// The slowest ticks, and whether it was work.
class SlowTicks {
public:
    void add(const TimedTick& tick) noexcept
    {
        ran_.add(static_cast<std::int64_t>(tick.ran));
        const auto place = std::ranges::find_if(
            slowest_, [&](const TimedTick& other) { return other.took < tick.took; });
        if (place == slowest_.end()) return;
        std::move_backward(place, slowest_.end() - 1, slowest_.end());
        *place = tick;
    }
    void print() const
    {
        print_quantiles("processor time", ran_);
        for (const TimedTick& tick : slowest_) {
            std::printf("  tick %8llu took %8.2f us, of which its thread ran %8.2f; %2d moves\n",
                        printable(tick.number), microseconds(tick.took), microseconds(tick.ran),
                        tick.moves);
        }
    }

private:
    std::array<TimedTick, 8> slowest_; ///< slowest first
    LatencyHistogram ran_;
};

/// The servo loop's own part: a renderer, and an account. Its thread's.
class ServoSide {
public:
    explicit ServoSide(const TouchModel& model)
        : renderer_(make_surface_renderer(*model.surface, model.map, *find_device("omni")))
    {}

    /// From what the device says to the force.
    const RenderTick& tick(const DeviceState& state, std::uint64_t number) noexcept
    {
        const std::int64_t ran = processor_time();
        const auto begin = std::chrono::steady_clock::now();
        const RenderTick& felt = renderer_.tick(state, tick_seconds);
        const auto took = (std::chrono::steady_clock::now() - begin) / std::chrono::nanoseconds(1);
        render_.add(took);
        slow_.add({.number = number,
                   .took = static_cast<std::uint64_t>(took),
                   .ran = static_cast<std::uint64_t>(processor_time() - ran),
                   .moves = static_cast<int>(felt.moves)});
        touching_ += felt.hold != Hold::free ? 1U : 0U;
        return felt;
    }

    void print(std::uint64_t ticks) const
    {
        std::printf("  touching in %.1f %% of ticks\n", percent(touching_, ticks));
        print_quantiles("from device to force", render_);
        print_histogram("from device to force", render_);
        slow_.print();
    }

private:
    HapticRenderer renderer_;
    LatencyHistogram render_;
    SlowTicks slow_;
    std::uint64_t touching_ = 0;
};

void print_servo(const ServoStatistics& servo)
{
    std::printf("  deadlines missed %llu: %llu woken too late by the system, %llu held up within "
                "the tick; ticks left out %llu\n",
                printable(servo.missed), printable(servo.overslept),
                printable(servo.missed - servo.overslept), printable(servo.skipped));
    std::printf("  page faults %llu; real-time priority: %s, locked memory: %s%s%s\n",
                printable(servo.page_faults), servo.real_time_priority ? "yes" : "no",
                servo.locked_memory ? "yes" : "no", servo.note.empty() ? "" : "; ",
                servo.note.c_str());
    print_quantiles("late by (jitter)", servo.late);
    print_quantiles("whole tick, hand and hand-over too", servo.work);
    print_histogram("late by", servo.late);
}

/// Both loops at once.
void run_once(const TouchModel& model, const MeshIndex& index, const HandScript& script,
              double seconds)
{
    ServoSide side(model);
    SimulatedHand hand({}, script.target(0));
    ServoStatistics servo;
    GraphicsLoop graphics(index, bounding_box(model.mesh));
    std::thread servo_thread([&] {
        const auto ticks = static_cast<std::uint64_t>(std::llround(seconds / tick_seconds));
        servo = run_servo_loop(
            {.rate = 1 / tick_seconds, .ticks = ticks, .pace = Pace::real_time},
            [&](std::uint64_t tick) noexcept {
                const RenderTick& felt = side.tick(hand.state(), tick);
                hand.step(felt.force, script.target(static_cast<double>(tick) * tick_seconds));
                return Flow::proceed;
            });
    });
    servo_thread.join();
    const ServoStatistics& drawn = graphics.stop();

    std::printf("servo loop: %.2f Hz, %llu ticks in %.1f s\n",
                static_cast<double>(servo.ticks) / servo.seconds, printable(servo.ticks),
                servo.seconds);
    print_servo(servo);
    side.print(servo.ticks);
    std::printf("graphics loop: %.2f Hz, %llu pictures of %d x %d rays, missed %llu\n",
                static_cast<double>(drawn.ticks) / drawn.seconds, printable(drawn.ticks),
                picture_width, picture_height, printable(drawn.missed));
    print_quantiles("a picture", drawn.work);
    (void)std::fflush(stdout);
}

} // namespace

int run_loops(const std::string& mesh, const TouchLoopOptions& options)
{
    const auto loaded = load_touch_model(mesh, options.keep);
    if (!loaded) {
        std::printf("%s: %s\n", mesh.c_str(), describe(loaded.error()).c_str());
        return 1;
    }
    const TouchModel& model = **loaded;
    const auto index = build_mesh_index(model.mesh);
    const auto script = HandScript::make(options.script, model.mesh, model.topology, model.map, 1);
    if (!index || !script) {
        const Error& error = index ? script.error() : index.error();
        std::printf("%s: %s\n", mesh.c_str(), describe(error).c_str());
        return 1;
    }
    std::printf("%s, %zu triangles, hand:%s, %u processors\n", mesh.c_str(),
                model.mesh.triangle_count(), options.script.c_str(),
                std::thread::hardware_concurrency());
    run_once(model, *index, *script, options.seconds);
    return 0;
}

} // namespace proxima::bench
