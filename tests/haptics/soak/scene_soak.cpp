#include "haptics/soak/scene_soak.h"

#include "haptics/force/surface_renderer.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/servo_tick.h"
#include "lab/hand_script.h"
#include "lab/simulated_hand.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace proxima::soak {

namespace {

using namespace testing;

struct SoakObject {
    TriangleMesh mesh;
    ScriptedObject scripted;
};

struct SoakScene {
    std::string name;
    std::vector<SoakObject> objects;
};

/// Scenes by a seed.
class SceneMaker {
public:
    explicit SceneMaker(std::uint64_t seed) : random_(seed) {}

    std::vector<SoakScene> make()
    {
        std::vector<SoakScene> scenes;
        scenes.push_back({"at rest", crowd(3, 0)});
        scenes.push_back({"slow", crowd(4, 1)});
        scenes.push_back({"fast", crowd(4, 10)});
        scenes.push_back({"swarm", crowd(12, 3)});
        scenes.push_back({"mill", mill()});
        scenes.push_back({"press", press()});
        return scenes;
    }

private:
    double number(double low, double high)
    {
        return std::uniform_real_distribution<double>(low, high)(random_);
    }
    Vec3 vector(double size)
    {
        return {number(-size, size), number(-size, size), number(-size, size)};
    }

    TriangleMesh any_mesh()
    {
        switch (random_() % 6) {
        case 0:
            return *sample_mesh("torus:12x8");
        case 1:
            return *sample_mesh("cube");
        case 2:
            return thin_plate();
        case 3:
            return bumpy_sheet(6);
        case 4:
            return triangle_soup(static_cast<std::uint32_t>(random_()), 20);
        default:
            return *sample_mesh("sphere:12x12");
        }
    }

    ObjectScript any_script(double speed)
    {
        if (speed == 0) return {};
        switch (random_() % 4) {
        case 0:
            return {
                .kind = ObjectMotionKind::spin, .along = vector(1), .angle = number(-2, 2) * speed};
        case 1:
            return {.kind = ObjectMotionKind::rock,
                    .along = vector(1),
                    .angle = number(0, 0.5),
                    .seconds = 3 / speed};
        case 2:
            return {.kind = ObjectMotionKind::swing, .along = vector(1), .seconds = 4 / speed};
        default:
            return {};
        }
    }

    std::vector<SoakObject> crowd(std::size_t count, double speed)
    {
        std::vector<SoakObject> objects;
        const double room = 1.2 * std::cbrt(static_cast<double>(count));
        for (std::size_t i = 0; i < count; ++i) {
            SoakObject object;
            object.mesh = any_mesh();
            object.scripted.pose = posed(number(-3, 3), vector(1), vector(room));
            object.scripted.script = any_script(speed);
            if (i % 3 == 1)
                object.scripted.material = SurfaceMaterial{.stiffness = number(50, 600)};
            objects.push_back(std::move(object));
        }
        return objects;
    }

    /// Thin blades that turn fast beside a wall.
    std::vector<SoakObject> mill()
    {
        std::vector<SoakObject> objects(3);
        for (SoakObject& object : objects) {
            object.mesh = thin_plate();
            object.scripted.script = {
                .kind = ObjectMotionKind::spin, .along = Vec3(1, 0.1, 0), .angle = number(10, 20)};
        }
        objects[1].scripted.pose = posed(0.9, Vec3(1, 0, 0), Vec3(1.4, 0.3, 0));
        objects[2].scripted.pose.translation = Vec3(0, 0, -1.6);
        objects[2].scripted.script = {};
        return objects;
    }

    /// Boxes that close on what is between them, and open again.
    std::vector<SoakObject> press()
    {
        std::vector<SoakObject> objects(3);
        objects[0].mesh = box_mesh(Vec3(1, 1, 0.3));
        objects[1].mesh = box_mesh(Vec3(1, 1, 0.3));
        objects[2].mesh = *sample_mesh("torus:12x8");
        objects[0].scripted.pose.translation = Vec3(0, 0, -0.9);
        objects[1].scripted.pose.translation = Vec3(0, 0, 0.9);
        objects[2].scripted.pose.translation = Vec3(2.2, 0, 0);
        objects[0].scripted.script = {
            .kind = ObjectMotionKind::swing, .along = Vec3(0, 0, 0.65), .seconds = 0.9};
        objects[1].scripted.script = {
            .kind = ObjectMotionKind::swing, .along = Vec3(0, 0, -0.65), .seconds = 0.7};
        return objects;
    }

    std::mt19937_64 random_;
};

std::unique_ptr<ScriptedScene> make_scene(const SoakScene& wanted, BodySearch search)
{
    std::vector<TouchBody> bodies;
    std::vector<ScriptedObject> objects;
    for (const SoakObject& object : wanted.objects) {
        bodies.push_back(body_of(object.mesh, {.material = object.scripted.material}, search));
        objects.push_back(object.scripted);
    }
    return std::move(*ScriptedScene::make(bodies, objects));
}

struct SceneTotals {
    std::uint64_t ticks = 0;
    std::uint64_t touching = 0;
    std::uint64_t squeezed = 0;
    std::uint64_t wrong = 0;
    std::uint64_t passes = 0;
    std::uint64_t near = 0;
    std::uint64_t over = 0;
    double apart = 0; ///< of the scene's reach

    void add(const SceneTotals& row)
    {
        ticks += row.ticks;
        touching += row.touching;
        squeezed += row.squeezed;
        wrong += row.wrong;
        passes += row.passes;
        near += row.near;
        over += row.over;
        apart = std::max(apart, row.apart);
    }
    [[nodiscard]] bool right() const { return wrong + passes + near + over == 0; }
    void print(const std::string& name, const std::string& script, double radius) const
    {
        std::printf("%-10s %-7s %6g", name.c_str(), script.c_str(), radius);
        for (const std::uint64_t number : {ticks, touching, squeezed, wrong, passes, near, over})
            std::printf(" %9llu", static_cast<unsigned long long>(number));
        std::printf(" %9.1e\n", apart);
        (void)std::fflush(stdout);
    }
};

/// The ways of one tick: carried along first, then among objects that stand.
std::uint64_t count_passes(const TouchScene& scene, const Vec3& before, std::span<const Vec3> path)
{
    std::uint64_t passes = passes_while_moving(scene, before, path.front()) ? 1 : 0;
    for (std::size_t i = 1; i < path.size(); ++i)
        passes += passes_standing(scene, path[i - 1], path[i]) ? 1U : 0U;
    return passes;
}

SceneTotals run_row(const SoakScene& wanted, const std::string& script_name, double radius,
                    std::uint64_t ticks, std::uint64_t seed)
{
    const auto fast = make_scene(wanted, BodySearch::index);
    const auto slow = make_scene(wanted, BodySearch::every_triangle);
    const TouchScene& scene = fast->scene();
    const TriangleMesh mesh = *scene_mesh(scene);
    const Topology topology = *build_topology(mesh);
    const WorkspaceMap map = fit_workspace(fast->bounds(), 0.1);
    std::vector<std::uint32_t> parts;
    std::uint32_t triangles = 0;
    for (const SoakObject& object : wanted.objects) {
        parts.push_back(triangles);
        triangles += static_cast<std::uint32_t>(object.mesh.triangle_count());
    }
    const auto script = HandScript::make(script_name, mesh, topology, map, seed, parts);
    if (!script) return {.wrong = 1};
    const DeviceLimits device = *find_device("omni");
    const RenderOptions render = {.proxy_radius = radius};
    HapticRenderer renderer = make_haptic_renderer(fast->scene(), map, device, render).value();
    HapticRenderer expected = make_haptic_renderer(slow->scene(), map, device, render).value();
    SimulatedHand hand({}, script->target(0));
    const double rounding = 0x1p-36 * moving_surface(scene).scale().reach;
    SceneTotals row;
    Vec3 before = Vec3::Zero();
    bool was_placed = false;
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
        const DeviceState state = hand.state();
        fast->send_motions(tick, tick_seconds);
        slow->send_motions(tick, tick_seconds);
        const RenderTick& felt = renderer.tick(state, tick_seconds);
        const RenderTick& should = expected.tick(state, tick_seconds);
        ++row.ticks;
        row.touching += felt.hold != Hold::free ? 1U : 0U;
        row.squeezed += felt.squeezed ? 1U : 0U;
        row.over += felt.slide_end == SlideEnd::overloaded ? 1U : 0U;
        const double apart =
            (felt.proxy - should.proxy).norm() / moving_surface(scene).scale().reach;
        row.apart = std::max(row.apart, apart);
        row.wrong += apart == 0 && felt.force == should.force ? 0U : 1U;
        const bool is_placed = felt.is_placed;
        if (was_placed && is_placed && !felt.squeezed)
            row.passes += count_passes(scene, before, renderer.path());
        if (is_placed) {
            const double least = parts_of(renderer).proxy().radius() - rounding;
            row.near += distance_of(scene, felt.proxy) >= least ? 0U : 1U;
        }
        before = felt.proxy;
        was_placed = is_placed;
        hand.step(felt.force, script->target(static_cast<double>(tick) * tick_seconds));
    }
    row.print(wanted.name, script_name, radius);
    return row;
}

} // namespace

int run_scene_soak(std::uint64_t ticks, std::uint64_t seed)
{
    constexpr std::array scripts = {"press", "slide", "stroke", "corner", "poke", "walk"};
    constexpr std::array radii = {0.0, 0.002};
    std::printf("seed %llu\n%-10s %-7s %6s %9s %9s %9s %9s %9s %9s %9s %9s\n",
                static_cast<unsigned long long>(seed), "scene", "script", "radius", "ticks",
                "touching", "squeezed", "wrong", "passes", "near", "over", "apart");
    SceneTotals totals;
    for (const SoakScene& scene : SceneMaker(seed).make()) {
        for (const char* const script : scripts) {
            for (const double radius : radii) {
                totals.add(run_row(scene, script, radius,
                                   ticks / (scripts.size() * radii.size()) + 1, seed));
            }
        }
    }
    totals.print("all", "", 0);
    std::printf("%s\n", totals.right() ? "nothing passed, nothing wrong" : "SOMETHING WAS WRONG");
    return totals.right() ? 0 : 1;
}

} // namespace proxima::soak
