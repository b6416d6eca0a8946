#include "touch_changes.h"

#include "haptics/scene/touch_access.h"
#include "haptics/touch_meshes.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"
#include "touch_table.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace proxima::bench {

namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr double frame_seconds = 1.0 / 60;
constexpr std::uint32_t cells = 100; ///< along each side of the cloth
constexpr double side = 0.2;         ///< m
constexpr double wave_height = 0.005;
constexpr double wave_length = 0.08;
constexpr double wave_hertz = 2;

/// The positions of the vertices of a cloth with waves at a time, row by row.
std::vector<Vec3> wave_positions(double seconds)
{
    std::vector<Vec3> positions;
    for (std::uint32_t i = 0; i <= cells; ++i) {
        for (std::uint32_t j = 0; j <= cells; ++j) {
            const double x = side * i / cells - side / 2;
            const double y = side * j / cells - side / 2;
            const double angle = turn * ((0.8 * x + 0.6 * y) / wave_length - wave_hertz * seconds);
            positions.emplace_back(x, y, wave_height * std::sin(angle));
        }
    }
    return positions;
}

Result<TriangleMesh> cloth_mesh()
{
    const TriangleMesh sheet = testing::bumpy_sheet(cells);
    return make_triangle_mesh(wave_positions(0),
                              {sheet.triangles().begin(), sheet.triangles().end()});
}

enum class Hand { rests, strokes, pokes };

Vec3 hand_position(Hand hand, double seconds)
{
    const double down = 0.03 - (0.03 + wave_height) * std::min(seconds / 0.1, 1.0);
    switch (hand) {
    case Hand::rests:
        break;
    case Hand::strokes:
        return {0.06 * std::sin(turn * 0.9 * seconds), 0.05 * std::cos(turn * 0.6 * seconds), down};
    case Hand::pokes:
        return {0.013, -0.007, down + wave_height * (1 - std::cos(turn * 3 * seconds))};
    }
    return {0.013, -0.007, down};
}

std::int64_t nanoseconds_since(std::chrono::steady_clock::time_point begin)
{
    return (std::chrono::steady_clock::now() - begin) / std::chrono::nanoseconds(1);
}

/// Times of the application's work, once a frame.
struct FrameTimes {
    TickTimes refit;
    TickTimes deform;
};

/// One session: a force, a kind, the work and the time of each tick.
struct Session {
    TouchTrack track;
    std::vector<std::int64_t> nanoseconds;
    std::uint64_t squeezed = 0;
};

Result<Session> run_session(const TouchBody& body, Hand hand, const TouchRaceOptions& options,
                            FrameTimes& frames)
{
    TouchScene scene({Vec3(-1, -1, -1), Vec3(1, 1, 1)});
    const auto object = scene.add(body, {});
    if (!object) return tl::unexpected(object.error());
    auto renderer = make_haptic_renderer(scene, WorkspaceMap{}, *find_device("omni"),
                                         {.proxy_radius = options.radius});
    if (!renderer) return tl::unexpected(renderer.error());
    Session session;
    int frame = 0;
    for (std::uint64_t tick = 0; tick < options.ticks; ++tick) {
        const double seconds = static_cast<double>(tick) * tick_seconds;
        if (seconds >= frame * frame_seconds) {
            ++frame;
            const std::vector<Vec3> positions = wave_positions(frame * frame_seconds);
            const auto begin = std::chrono::steady_clock::now();
            const auto shape = refit_touch_body(body, positions);
            if (!shape) return tl::unexpected(shape.error());
            frames.refit.add(nanoseconds_since(begin));
            const auto middle = std::chrono::steady_clock::now();
            if (Status status = scene.deform(*object, *shape, frame_seconds); !status)
                return tl::unexpected(status.error());
            frames.deform.add(nanoseconds_since(middle));
        }
        DeviceState state;
        state.pose.translation = hand_position(hand, seconds);
        const ContactWork before = moving_surface(scene).work();
        const auto begin = std::chrono::steady_clock::now();
        const RenderTick& felt = renderer->tick(state, tick_seconds);
        session.nanoseconds.push_back(nanoseconds_since(begin));
        session.squeezed += felt.squeezed ? 1U : 0U;
        session.track.states.push_back(state);
        session.track.forces.push_back(felt.force);
        session.track.kinds.push_back(state_of(felt));
        session.track.work.push_back(difference(moving_surface(scene).work(), before));
    }
    return session;
}

/// Adds the least time of each tick of several sessions. Returns the ticks whose force was another.
Result<std::uint64_t> race(const TouchBody& body, Hand hand, const TouchRaceOptions& options,
                           TickSums& sums, FrameTimes& frames)
{
    auto first = run_session(body, hand, options, frames);
    if (!first) return tl::unexpected(first.error());
    std::uint64_t wrong = first->squeezed;
    TrackTimes times;
    times.nanoseconds = std::move(first->nanoseconds);
    for (int round = 1; round < options.replays; ++round) {
        const auto again = run_session(body, hand, options, frames);
        if (!again) return tl::unexpected(again.error());
        for (std::size_t i = 0; i < times.nanoseconds.size(); ++i) {
            times.nanoseconds[i] = std::min(times.nanoseconds[i], again->nanoseconds[i]);
            wrong += again->track.forces[i] != first->track.forces[i] ? 1U : 0U;
        }
    }
    add_track(sums, first->track, times);
    return wrong;
}

} // namespace

int run_changes(const TouchRaceOptions& options)
{
    const auto mesh = cloth_mesh();
    auto body = mesh ? build_touch_body(*mesh) : Result<TouchBody>(tl::unexpected(mesh.error()));
    std::printf(
        "a cloth of 20,000 triangles changes its shape at 60 Hz, proxy radius %g m; least of "
        "%d replays\n",
        options.radius, options.replays);
    print_head("hand");
    FrameTimes frames;
    std::uint64_t wrong = 0;
    for (const auto& [hand, name] :
         {std::pair{Hand::rests, "rests"}, {Hand::strokes, "strokes"}, {Hand::pokes, "pokes"}}) {
        TickSums sums;
        const auto differing = body ? race(*body, hand, options, sums, frames)
                                    : Result<std::uint64_t>(tl::unexpected(body.error()));
        if (!differing) {
            std::printf("%s\n", describe(differing.error()).c_str());
            return 1;
        }
        wrong += *differing;
        print_rows(name, sums, true);
    }
    for (const auto& [name, times] :
         {std::pair{"refit_touch_body", &frames.refit}, {"deform", &frames.deform}}) {
        std::printf("%-16s of a frame: %.2f ms in the median, %.2f ms of all but a hundredth\n",
                    name, 1e-3 * times->microseconds(0.5), 1e-3 * times->microseconds(0.99));
    }
    if (wrong > 0) {
        std::printf("%llu ticks without room or with ANOTHER FORCE\n",
                    static_cast<unsigned long long>(wrong));
    }
    std::printf("\n");
    return wrong > 0 ? 1 : 0;
}

} // namespace proxima::bench
