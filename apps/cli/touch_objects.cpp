#include "cli/touch_objects.h"

#include "base/text.h"
#include "cli/model_options.h"
#include "cli/stopwatch.h"
#include "cli/touch_texture.h"
#include "haptics/scene/touch_access.h"
#include "proxima/mesh_index.h"

#include <array>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

Result<TouchBody> load_body(const std::string& name, const TouchBodyOptions& options, bool lists,
                            Session& session)
{
    if (is_index_file(name)) {
        auto index = load_index_file(name, session);
        if (!index) return tl::unexpected(index.error());
        const ProgressBar shown(session.progress(), session.bar());
        auto body = build_touch_body(*index, options);
        if (!body && body.error().code == ErrorCode::broken_invariant)
            return fail(ErrorCode::malformed_file, describe(body.error()), name);
        if (!body) return at_model(body.error(), name);
        return body;
    }
    auto mesh = session.load_model(name);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    auto body = [&]() -> Result<TouchBody> {
        if (!lists) return build_touch_body(std::move(*mesh), options);
        auto index = build_mesh_index(*mesh, {.execution = options.execution});
        if (index) index = with_lists(*index, {.execution = options.execution});
        if (!index) return tl::unexpected(index.error());
        return build_touch_body(*index, options);
    }();
    if (!body) return at_model(body.error(), name);
    return body;
}

std::string words_of(const ObjectScript& script)
{
    const Vec3& v = script.along;
    const double degrees = script.angle / radians_per_degree;
    switch (script.kind) {
    case ObjectMotionKind::rest:
        break;
    case ObjectMotionKind::spin:
        return fmt::format("spins {:g} degrees a second about ({:g}, {:g}, {:g})", degrees, v.x(),
                           v.y(), v.z());
    case ObjectMotionKind::rock:
        return fmt::format("rocks {:g} degrees in {:g} s about ({:g}, {:g}, {:g})", degrees,
                           script.seconds, v.x(), v.y(), v.z());
    case ObjectMotionKind::swing:
        return fmt::format("swings ({:g}, {:g}, {:g}) in {:g} s", v.x(), v.y(), v.z(),
                           script.seconds);
    }
    return "rests";
}

Json motion_json(const ObjectScript& script)
{
    constexpr std::array names = {"rest", "spin", "rock", "swing"};
    return {{"kind", names[static_cast<std::size_t>(script.kind)]},
            {"along", {script.along.x(), script.along.y(), script.along.z()}},
            {"degrees", script.angle / radians_per_degree},
            {"seconds", script.seconds}};
}

Json pose_json(const RigidTransform& pose)
{
    Json rows = Json::array();
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) rows.push_back(pose.rotation(row, column));
        rows.push_back(pose.translation[row]);
    }
    return rows;
}

} // namespace

Result<std::unique_ptr<TouchModel>> load_touch_scene(const ScenePlan& plan, ForceShading shading,
                                                     bool lists, const std::string& path,
                                                     Session& session)
{
    const Stopwatch watch;
    auto model = std::make_unique<TouchModel>();
    std::vector<ScriptedObject> objects = plan.objects;
    std::vector<TouchBody> bodies;
    std::uint32_t triangles = 0;
    for (std::size_t i = 0; i < plan.models.size(); ++i) {
        auto body = load_body(plan.models[i],
                              {.material = objects[i].material,
                               .texture = objects[i].texture,
                               .shading = shading,
                               .execution = session.execution()},
                              lists, session);
        if (!body) return tl::unexpected(body.error());
        const std::uint64_t fingerprint = contact_body(*body).mesh_index().mesh_fingerprint();
        if (objects[i].mesh_fingerprint != 0 && objects[i].mesh_fingerprint != fingerprint) {
            return fail(ErrorCode::invalid_argument,
                        concat("was recorded with another model as object ", i, " than ",
                               plan.models[i], ": replay it with the ones that were touched"),
                        path);
        }
        objects[i].mesh_fingerprint = fingerprint;
        model->parts.push_back(triangles);
        triangles += static_cast<std::uint32_t>(body->mesh().triangle_count());
        bodies.push_back(*body);
    }
    auto scene = ScriptedScene::make(bodies, objects, plan.room);
    if (!scene) return tl::unexpected(scene.error());
    model->scene = std::move(*scene);
    auto mesh = scene_mesh(model->scene->scene());
    if (!mesh) return tl::unexpected(mesh.error());
    auto surface = surface_of(std::move(*mesh), plan.models.front(), session);
    if (!surface) return tl::unexpected(surface.error());
    model->surface = std::move(*surface);
    model->object_names = plan.models;
    model->reach = model->scene->bounds();
    model->room = plan.room;
    model->build_seconds = watch.seconds();
    return model;
}

std::string in_words(const SurfaceMaterial& material)
{
    return fmt::format("K {:g} N/m, B {:g} N s/m, friction {:g} and {:g}", material.stiffness,
                       material.damping, material.static_friction, material.dynamic_friction);
}

std::string objects_text(const TouchModel& model, const QualityReport& quality)
{
    if (model.scene == nullptr) return {};
    std::string text =
        fmt::format("{} objects, moving in {} ticks, squeezing the proxy in {}\n",
                    quality.objects.size(), quality.moving_ticks, quality.squeezed_ticks);
    for (std::size_t i = 0; i < quality.objects.size(); ++i) {
        const ObjectQuality& object = quality.objects[i];
        const ScriptedObject& scripted = model.scene->objects()[i];
        const SceneObject there =
            moving_surface(model.scene->scene()).object(ObjectId{static_cast<std::uint32_t>(i)});
        text +=
            fmt::format("  {} {}: {} triangles{}, {}; touched in {} ticks, surface at most {:.3f} "
                        "m/s\n",
                        i, model.object_names[i], there.body->mesh().triangle_count(),
                        scripted.material ? ", " + in_words(*scripted.material) : "",
                        words_of(scripted.script), object.touching_ticks, object.max_carrying);
    }
    return text;
}

Json objects_json(const TouchModel& model, const QualityReport& quality)
{
    if (model.scene == nullptr) return nullptr;
    Json rows = Json::array();
    for (std::size_t i = 0; i < quality.objects.size(); ++i) {
        const ObjectQuality& object = quality.objects[i];
        const ScriptedObject& scripted = model.scene->objects()[i];
        const SceneObject there =
            moving_surface(model.scene->scene()).object(ObjectId{static_cast<std::uint32_t>(i)});
        Json material;
        if (scripted.material) {
            material = {{"stiffness", scripted.material->stiffness},
                        {"damping", scripted.material->damping},
                        {"static_friction", scripted.material->static_friction},
                        {"dynamic_friction", scripted.material->dynamic_friction}};
        }
        rows.push_back({{"model", model.object_names[i]},
                        {"triangles", there.body->mesh().triangle_count()},
                        {"pose", pose_json(scripted.pose)},
                        {"motion", motion_json(scripted.script)},
                        {"material", material},
                        {"texture", scripted.texture ? texture_json(*scripted.texture) : Json()},
                        {"touching_ticks", object.touching_ticks},
                        {"moving_ticks", object.moving_ticks},
                        {"max_carrying", object.max_carrying}});
    }
    return rows;
}

} // namespace proxima
