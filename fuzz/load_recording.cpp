// Feeds files with right checksums and any content to the loader of recordings, and replays the
// first ticks of what it accepts, as `proxima touch --device replay:FILE` does: forces are finite and
// within the device's limit. Whatever the fingerprints say, the cube is touched. Seeds are a session
// with one model, with penalty forces, with a scene of three objects, with textures, and with an image.
#include "base/binary_file.h"
#include "base/check.h"
#include "exact_copy.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/loop/recording.h"
#include "haptics/scene/scripted_scene.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/surface/shading_normals.h"
#include "lab/quality_report.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "proxima/touch_scene.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace {

using namespace proxima;

constexpr std::size_t most_ticks = 64;

/// A model at rest.
struct Model {
    TriangleMesh mesh = *sample_mesh("cube");
    Topology topology = *build_topology(mesh);
    MeshIndex index = *with_signs(*build_mesh_index(mesh));
    IndexContactSurface surface{index};
    ShadingNormals normals{mesh, topology};
};

DeviceLimits limits_of(const RecordingSettings& settings)
{
    return {.name = "recorded",
            .max_force = settings.max_force,
            .max_stiffness = settings.max_stiffness,
            .max_damping = settings.max_damping};
}

void replay(const Recording& recording, HapticRenderer renderer, QualityMeter meter,
            ScriptedScene* scene)
{
    const RecordingSettings& settings = recording.settings;
    const std::size_t ticks = std::min(recording.ticks.size(), most_ticks);
    for (std::size_t i = 0; i < ticks; ++i) {
        if (scene != nullptr) {
            for (const SceneMessage& message : recording.messages)
                if (message.tick == i) (void)apply(message, scene->scene());
            scene->send_motions(i, settings.tick_seconds);
        }
        const DeviceState state = device_state(recording.ticks[i]);
        const RenderTick& tick = renderer.tick(state, settings.tick_seconds);
        PROXIMA_CHECK(tick.force.allFinite());
        PROXIMA_CHECK_LE(tick.force.norm(), settings.max_force);
        meter.add(tick, state.velocity, renderer.path());
        (void)same_response(recorded(recording.ticks[i].seconds, state, tick), recording.ticks[i]);
    }
}

void replay_model(const Recording& recording, const Model& model)
{
    const RecordingSettings& settings = recording.settings;
    const DeviceLimits limits = limits_of(settings);
    const bool shades = settings.render.shading == ForceShading::on;
    replay(recording,
           settings.law == ForceLaw::penalty
               ? make_penalty_renderer(model.surface, model.index, settings.map, limits,
                                       settings.render)
               : make_surface_renderer(model.surface, settings.map, limits, settings.render,
                                       shades ? &model.normals : nullptr),
           QualityMeter(model.surface, settings.map), nullptr);
}

void replay_scene(const Recording& recording, const Model& model)
{
    const RecordingSettings& settings = recording.settings;
    std::vector<TouchBody> bodies;
    for (const ScriptedObject& object : settings.objects) {
        auto body = build_touch_body(model.index, {.material = object.material,
                                                   .texture = object.texture,
                                                   .shading = settings.render.shading});
        PROXIMA_CHECK(body.has_value());
        bodies.push_back(*body);
    }
    const auto scene = ScriptedScene::make(bodies, settings.objects, settings.room);
    if (!scene) return;
    (void)scene_mesh((*scene)->scene());
    replay(
        recording,
        make_haptic_renderer((*scene)->scene(), settings.map, limits_of(settings), settings.render)
            .value(),
        QualityMeter((*scene)->scene(), settings.map), scene->get());
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    static const Model model;
    const auto copy = testing::exact_copy(data, size);
    reseal_binary_file({copy.get(), size});
    const auto recording = load_recording({copy.get(), size}, copy, "fuzz");
    if (!recording) {
        PROXIMA_CHECK(!recording.error().message.empty());
        PROXIMA_CHECK(!recording.error().where.empty());
        return 0;
    }
    const RecordingSettings& settings = recording->settings;
    PROXIMA_CHECK(
        check_render_settings(settings.map, limits_of(settings), settings.render).has_value());
    if (settings.objects.empty()) {
        replay_model(*recording, model);
    } else {
        replay_scene(*recording, model);
    }
    return 0;
}
