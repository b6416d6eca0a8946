#include "touch_replay.h"
#include "bindings.h"
#include "haptics/channel/scene_message.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/exits.h"
#include "haptics/surface/shading_normals.h"
#include "index_methods.h"
#include "proxima/mesh_index.h"
#include "run.h"
#include "touch.h"

#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// What is touched again: a model at rest, or a scene. The renderer refers to the others.
struct Replayed {
    std::unique_ptr<ScriptedScene> scene;
    std::unique_ptr<const IndexContactSurface> surface;
    std::unique_ptr<ShadingNormals> normals;  ///< of a model at rest whose forces are shaded
    std::unique_ptr<const TriangleMesh> mesh; ///< of these normals
    std::unique_ptr<const MeshIndex> inside;  ///< of penalty forces
    std::optional<HapticRenderer> renderer;
};

DeviceLimits limits_of_recording(const RecordingSettings& settings)
{
    return {.name = "recorded",
            .max_force = settings.max_force,
            .max_stiffness = settings.max_stiffness,
            .max_damping = settings.max_damping};
}

[[noreturn]] void refuse_model(const std::string& which)
{
    refuse(which, "is not the one that was recorded: replay with the one that was touched");
}

/// As `proxima touch` has it.
Result<Replayed> touch_again(const RecordingSettings& settings, const MeshIndex& index,
                             Progress* progress)
{
    const DeviceLimits limits = limits_of_recording(settings);
    if (Status status = check_render_settings(settings.map, limits, settings.render); !status)
        return tl::unexpected(status.error());
    Replayed replayed;
    const auto with = with_exits(index, {.progress = progress});
    if (!with) return tl::unexpected(with.error());
    auto surface = IndexContactSurface::make(*with);
    if (!surface) return tl::unexpected(surface.error());
    replayed.surface = std::move(*surface);
    if (settings.law == ForceLaw::penalty) {
        const auto inside = with_signs(index, {.execution = {.progress = progress}});
        if (!inside) return tl::unexpected(inside.error());
        replayed.inside = std::make_unique<const MeshIndex>(*inside);
        replayed.renderer = make_penalty_renderer(*replayed.surface, *replayed.inside, settings.map,
                                                  limits, settings.render);
        return replayed;
    }
    if (settings.render.shading == ForceShading::on) {
        auto mesh = mesh_of(index);
        if (!mesh) return tl::unexpected(mesh.error());
        replayed.mesh = std::make_unique<const TriangleMesh>(std::move(*mesh));
        const auto topology = build_topology(*replayed.mesh);
        if (!topology) return tl::unexpected(topology.error());
        replayed.normals = std::make_unique<ShadingNormals>(*replayed.mesh, *topology);
    }
    replayed.renderer = make_surface_renderer(*replayed.surface, settings.map, limits,
                                              settings.render, replayed.normals.get());
    return replayed;
}

Replayed of_model(const RecordingSettings& settings, const py::object& model)
{
    const MeshIndex index = index_of(model, "a proxima.Mesh or Index");
    if (index.mesh_fingerprint() != settings.mesh_fingerprint) refuse_model("model");
    return run(py::none(), Duration::lengthy,
               [&](Progress* progress) { return touch_again(settings, index, progress); });
}

Replayed of_scene(const RecordingSettings& settings, const py::object& models)
{
    if (!py::isinstance<py::sequence>(models) || py::len(models) != settings.objects.size()) {
        refuse("model", "must be a list of the scene's " + std::to_string(settings.objects.size()) +
                            " objects");
    }
    std::vector<TouchBody> bodies;
    for (const py::handle model : models) {
        const ScriptedObject& object = settings.objects[bodies.size()];
        const MeshIndex index =
            index_of(py::reinterpret_borrow<py::object>(model), "a proxima.Mesh or Index");
        if (index.mesh_fingerprint() != object.mesh_fingerprint)
            refuse_model("model " + std::to_string(bodies.size()));
        bodies.push_back(body_of(index, {.material = object.material,
                                         .texture = object.texture,
                                         .shading = settings.render.shading}));
    }
    Replayed replayed;
    replayed.scene = value_of(ScriptedScene::make(bodies, settings.objects, settings.room));
    replayed.renderer = value_of(make_haptic_renderer(
        replayed.scene->scene(), settings.map, limits_of_recording(settings), settings.render));
    return replayed;
}

/// Moves the objects of a scene as they were moved before this tick.
Status move_objects(ScriptedScene& scene, const Recording& recording, std::uint64_t tick,
                    std::size_t& applied)
{
    const auto& messages = recording.messages;
    for (; applied < messages.size() && messages[applied].tick <= tick; ++applied) {
        if (Status status = apply(messages[applied], scene.scene()); !status) return status;
    }
    scene.send_motions(tick, recording.settings.tick_seconds);
    return {};
}

} // namespace

py::object replay(const std::filesystem::path& path, const py::object& model,
                  const py::object& progress)
{
    const Recording recording = run(progress, Duration::lengthy, [&](Progress* watched) {
        return load_recording(path, watched);
    });
    const RecordingSettings& settings = recording.settings;
    Replayed replayed =
        settings.objects.empty() ? of_model(settings, model) : of_scene(settings, model);

    const std::size_t count = recording.ticks.size();
    TouchColumns columns(count, replayed.scene != nullptr);
    auto seconds = new_array<double>(count);
    auto positions = new_rows<double>(count, 3);
    auto velocities = new_rows<double>(count, 3);
    auto forces = new_rows<double>(count, 3);
    double* const second = seconds.mutable_data();
    const auto position = elements_of<Vec3>(positions);
    const auto velocity = elements_of<Vec3>(velocities);
    const auto force = elements_of<Vec3>(forces);
    std::uint64_t differences = 0;
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        watched->begin_stage("touching", count);
        std::size_t applied = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the replay was cancelled");
            const RecordedTick& tick = recording.ticks[i];
            if (replayed.scene != nullptr) {
                if (Status moved = move_objects(*replayed.scene, recording, i, applied); !moved)
                    return moved;
            }
            const DeviceState state = device_state(tick);
            const RenderTick& felt = replayed.renderer->tick(state, settings.tick_seconds);
            if (!same_response(tick, recorded(tick.seconds, state, felt))) ++differences;
            columns.set(i, felt);
            second[i] = tick.seconds;
            position[i] = Vec3(tick.position.data());
            velocity[i] = Vec3(tick.velocity.data());
            force[i] = Vec3(tick.force.data());
            watched->advance(1);
        }
        return {};
    });
    return result_type("Replay")(
        columns.result(false), seconds, positions, velocities, forces, differences,
        settings.tick_seconds, settings.map.units_per_metre,
        array_of<double>(std::span<const double>(settings.map.center.data(), 3)));
}

} // namespace proxima::python
