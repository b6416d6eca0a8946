#include "touch_loops.h"

#include "proxima/haptics/collision_loop.h"
#include "proxima/haptics/hand_script.h"
#include "proxima/haptics/haptic_renderer.h"
#include "proxima/haptics/quality_report.h"
#include "proxima/haptics/servo_loop.h"
#include "proxima/haptics/simulated_hand.h"
#include "proxima/octree/build_octree.h"
#include "proxima/query/build_ray_index.h"
#include "proxima/query/cast_ray.h"
#include "touch_model.h"
#include "touch_track.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
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
    GraphicsLoop(const RayIndex& index, const Box& box)
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

    const RayIndex& index_;
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

} // namespace

int run_loops(const std::string& mesh, const TouchLoopOptions& options)
{
    const auto loaded = load_touch_model(mesh, options.keep);
    if (!loaded) {
        std::printf("%s: %s\n", mesh.c_str(), describe(loaded.error()).c_str());
        return 1;
    }
    const TouchModel& model = **loaded;
    const auto octree = build_octree(model.mesh);
    const auto index = octree ? build_ray_index(*octree, model.mesh)
                              : Result<RayIndex>(tl::unexpected(octree.error()));
    const auto script = HandScript::make(options.script, model.mesh, model.topology, model.map, 1);
    if (!index || !script) {
        const Error& error = index ? script.error() : index.error();
        std::printf("%s: %s\n", mesh.c_str(), describe(error).c_str());
        return 1;
    }

    HapticRenderer renderer(*model.surface, model.map, *find_device("omni"));
    SimulatedHand hand({}, script->target(0));
    LatencyHistogram render;
    std::uint64_t touching = 0;
    std::uint64_t patches = 0;
    PatchExchange exchange;
    ServoStatistics servo;
    CollisionLoop collision(*model.surface, exchange, {.speed = model.map.units_per_metre});
    GraphicsLoop graphics(*index, bounding_box(model.mesh));
    std::thread servo_thread([&] {
        const auto ticks = static_cast<std::uint64_t>(std::llround(options.seconds / tick_seconds));
        servo = run_servo_loop(
            {.rate = 1 / tick_seconds, .ticks = ticks, .pace = Pace::real_time},
            [&](std::uint64_t tick) noexcept {
                const DeviceState state = hand.state();
                const auto begin = std::chrono::steady_clock::now();
                const RenderTick& felt = renderer.tick(state, tick_seconds);
                render.add((std::chrono::steady_clock::now() - begin) /
                           std::chrono::nanoseconds(1));
                touching += felt.proxy.hold != Hold::free ? 1U : 0U;
                exchange.say({model.map.to_model(felt.position), felt.proxy.proxy, tick});
                patches += exchange.take() != nullptr ? 1U : 0U;
                hand.step(felt.force, script->target(static_cast<double>(tick) * tick_seconds));
                return Flow::proceed;
            });
    });
    servo_thread.join();
    const ServoStatistics& drawn = graphics.stop();
    const ServoStatistics& made = collision.stop();

    std::printf("%s, %zu triangles, hand:%s, %.0f s, %u processors\n", mesh.c_str(),
                model.mesh.triangle_count(), options.script.c_str(), servo.seconds,
                std::thread::hardware_concurrency());
    std::printf("servo loop: %.2f Hz, %llu ticks, %.1f %% touching; asks the octree itself\n",
                static_cast<double>(servo.ticks) / servo.seconds, printable(servo.ticks),
                100 * static_cast<double>(touching) / static_cast<double>(servo.ticks));
    std::printf("  deadlines missed %llu: %llu woken too late by the system, %llu held up within "
                "the tick; ticks left out %llu\n",
                printable(servo.missed), printable(servo.overslept),
                printable(servo.missed - servo.overslept), printable(servo.skipped));
    std::printf("  page faults %llu; real-time priority: %s, locked memory: %s%s%s\n",
                printable(servo.page_faults), servo.real_time_priority ? "yes" : "no",
                servo.locked_memory ? "yes" : "no", servo.note.empty() ? "" : "; ",
                servo.note.c_str());
    print_quantiles("late by (jitter)", servo.late);
    print_quantiles("from device to force", render);
    print_quantiles("whole tick, hand and hand-over too", servo.work);
    print_histogram("late by", servo.late);
    print_histogram("from device to force", render);
    std::printf("collision loop: %.2f Hz, %llu patches, missed %llu\n",
                static_cast<double>(made.ticks) / made.seconds, printable(collision.patches()),
                printable(made.missed));
    print_quantiles("a patch", made.work);
    std::printf("graphics loop: %.2f Hz, %llu pictures of %d x %d rays, missed %llu\n",
                static_cast<double>(drawn.ticks) / drawn.seconds, printable(drawn.ticks),
                picture_width, picture_height, printable(drawn.missed));
    print_quantiles("a picture", drawn.work);
    std::printf("ticks with a patch at hand: %llu\n", printable(patches));
    return 0;
}

} // namespace proxima::bench
