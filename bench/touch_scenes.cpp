#include "touch_scenes.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/scene/touch_access.h"
#include "lab/hand_script.h"
#include "lab/quality_report.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"
#include "touch_table.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace proxima::bench {

namespace {

constexpr double workspace_radius = 0.1; // m, the Phantom Omni's

/// An object of a scene: a model that is fitted into a unit cube, at a place.
struct PlacedModel {
    std::string model;
    Vec3 place = Vec3::Zero();
};

struct BenchScene {
    std::string name;
    std::vector<PlacedModel> models;
    bool moves = false;
};

ObjectScript script_of(std::size_t object)
{
    constexpr double turn = 1.5; // rad/s
    switch (object % 3) {
    case 0:
        return {.kind = ObjectMotionKind::spin, .along = Vec3(0.2, 0, 1), .angle = turn};
    case 1:
        return {.kind = ObjectMotionKind::swing, .along = Vec3(0.1, 0.2, -0.1), .seconds = 1.7};
    default:
        return {
            .kind = ObjectMotionKind::rock, .along = Vec3(0, 1, 0.3), .angle = 0.3, .seconds = 1.1};
    }
}

std::vector<BenchScene> bench_scenes()
{
    const std::string bunny = "/usr/share/glmark2/models/bunny.obj";
    std::vector<PlacedModel> three = {{"torus:200x100", Vec3(0, 0, 0)},
                                      {"sphere:30x30", Vec3(0.9, 0, 0.2)},
                                      {"spaceship:33000", Vec3(0, 0.9, 0)}};
    if (std::filesystem::exists(bunny)) three.push_back({bunny, Vec3(0, 0, 0.9)});
    std::vector<PlacedModel> herd;
    for (int i = 0; i < 4; ++i) {
        const int row = i / 2;
        const Vec3 place(0.8 * (i % 2), 0.8 * row, 0.1 * i);
        herd.push_back({std::filesystem::exists(bunny) ? bunny : "torus:200x175", place});
    }
    std::vector<PlacedModel> many;
    for (int i = 0; i < 64; ++i) {
        const int row = i / 4 % 4;
        const int layer = i / 16;
        const Vec3 place(0.9 * (i % 4), 0.9 * row, 0.9 * layer);
        many.push_back({"torus:24x12", place});
    }
    return {{"one at rest", {three.front()}, false},
            {"one moves", {three.front()}, true},
            {"several at rest", three, false},
            {"several move", three, true},
            {"4 large move", herd, true},
            {"64 at rest", many, false},
            {"64 move", many, true}};
}

Result<TriangleMesh> unit_mesh(const std::string& name)
{
    auto mesh = is_sample_mesh_name(name) ? sample_mesh(name) : read_mesh(name);
    if (!mesh) return mesh;
    const Box box = bounding_box(*mesh);
    const double size = box.extent().maxCoeff();
    std::vector<Vec3> positions;
    positions.reserve(mesh->vertex_count());
    for (const Vec3& p : mesh->positions()) positions.emplace_back((p - box.center()) / size);
    return make_triangle_mesh(std::move(positions),
                              {mesh->triangles().begin(), mesh->triangles().end()});
}

Result<std::unique_ptr<ScriptedScene>> make_scene(const BenchScene& wanted)
{
    std::vector<TouchBody> bodies;
    std::vector<ScriptedObject> objects;
    for (const PlacedModel& placed : wanted.models) {
        auto mesh = unit_mesh(placed.model);
        if (!mesh) return tl::unexpected(mesh.error());
        auto index = build_mesh_index(*mesh);
        if (index) index = with_lists(*index);
        if (!index) return tl::unexpected(index.error());
        auto body = build_touch_body(*index);
        if (!body) return tl::unexpected(body.error());
        ScriptedObject object;
        object.pose.translation = placed.place;
        if (wanted.moves) object.script = script_of(objects.size());
        objects.push_back(object);
        bodies.push_back(*body);
    }
    return ScriptedScene::make(bodies, objects);
}

/// First triangles of the objects.
std::vector<std::uint32_t> parts_of(const TouchScene& scene)
{
    std::vector<std::uint32_t> parts;
    std::uint32_t triangles = 0;
    for (std::uint32_t i = 0; i < scene.object_count(); ++i) {
        parts.push_back(triangles);
        triangles += static_cast<std::uint32_t>(
            moving_surface(scene).object(ObjectId{i}).body->mesh().triangle_count());
    }
    return parts;
}

/// A session of a scene, and the time of each of its ticks.
class SceneRace {
public:
    SceneRace(ScriptedScene& scripted, const TouchRaceOptions& options)
        : scripted_(scripted), options_(options),
          map_(fit_workspace(scripted.bounds(), workspace_radius))
    {}

    void run(const std::string& script_name, const TriangleMesh& mesh, const Topology& topology)
    {
        const auto script =
            HandScript::make(script_name, mesh, topology, map_, 1, parts_of(scripted_.scene()));
        if (!script) return;
        TouchTrack track;
        scripted_.rewind();
        HapticRenderer renderer = make_renderer();
        QualityMeter meter(scripted_.scene(), map_);
        SimulatedHand hand({}, script->target(0));
        for (std::uint64_t tick = 0; tick < options_.ticks; ++tick) {
            const DeviceState state = hand.state();
            const ContactWork before = moving_surface(scripted_.scene()).work();
            scripted_.send_motions(tick, tick_seconds);
            const RenderTick& felt = renderer.tick(state, tick_seconds);
            meter.add(felt, state.velocity, renderer.path());
            track.states.push_back(state);
            track.forces.push_back(felt.force);
            track.kinds.push_back(state_of(felt));
            track.work.push_back(difference(moving_surface(scripted_.scene()).work(), before));
            hand.step(felt.force, script->target(static_cast<double>(tick) * tick_seconds));
        }
        passes_ += meter.report().passes;
        squeezed_ += meter.report().squeezed_ticks;
        add_track(sums_, track, replay(track));
    }

    void print(const std::string& name) const
    {
        print_rows(name, sums_, true);
        if (passes_ + squeezed_ + differences_ == 0) return;
        std::printf(
            "%llu moves PASSED a triangle, %llu ticks without room, %llu replayed ticks gave "
            "ANOTHER FORCE\n",
            static_cast<unsigned long long>(passes_), static_cast<unsigned long long>(squeezed_),
            static_cast<unsigned long long>(differences_));
    }

    [[nodiscard]] bool right() const { return passes_ + differences_ == 0; }

private:
    [[nodiscard]] HapticRenderer make_renderer()
    {
        return make_haptic_renderer(scripted_.scene(), map_, *find_device("omni"),
                                    {.proxy_radius = options_.radius})
            .value();
    }

    TrackTimes replay(const TouchTrack& track)
    {
        TrackTimes times;
        times.nanoseconds.assign(track.states.size(), std::numeric_limits<std::int64_t>::max());
        for (int round = 0; round < options_.replays; ++round) {
            scripted_.rewind();
            HapticRenderer renderer = make_renderer();
            for (std::size_t tick = 0; tick < track.states.size(); ++tick) {
                scripted_.send_motions(tick, tick_seconds);
                const auto begin = std::chrono::steady_clock::now();
                const RenderTick& felt = renderer.tick(track.states[tick], tick_seconds);
                const std::int64_t spent =
                    (std::chrono::steady_clock::now() - begin) / std::chrono::nanoseconds(1);
                times.nanoseconds[tick] = std::min(times.nanoseconds[tick], spent);
                differences_ += felt.force != track.forces[tick] ? 1U : 0U;
            }
        }
        return times;
    }

    ScriptedScene& scripted_;
    const TouchRaceOptions& options_;
    WorkspaceMap map_;
    TickSums sums_;
    std::uint64_t passes_ = 0;
    std::uint64_t squeezed_ = 0;
    std::uint64_t differences_ = 0;
};

} // namespace

int run_scenes(const TouchRaceOptions& options)
{
    std::printf("scenes, proxy radius %g m; all scripts together, least of %d replays\n",
                options.radius, options.replays);
    print_head("scene");
    int status = 0;
    for (const BenchScene& wanted : bench_scenes()) {
        auto scripted = make_scene(wanted);
        const auto mesh = scripted ? scene_mesh((*scripted)->scene())
                                   : Result<TriangleMesh>(tl::unexpected(scripted.error()));
        const auto topology =
            mesh ? build_topology(*mesh) : Result<Topology>(tl::unexpected(mesh.error()));
        if (!topology) {
            std::printf("%s: %s\n", wanted.name.c_str(), describe(topology.error()).c_str());
            return 1;
        }
        SceneRace race(**scripted, options);
        for (const char* const script : touch_scripts) race.run(script, *mesh, *topology);
        race.print(wanted.name);
        (void)std::fflush(stdout);
        status |= race.right() ? 0 : 1;
    }
    std::printf("\n");
    return status;
}

} // namespace proxima::bench
