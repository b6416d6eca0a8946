#include "cli/touch_objects.h"

#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/stopwatch.h"
#include "proxima/base/text.h"
#include "proxima/geometry/rigid_transform.h"

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

constexpr double radians_per_degree = std::numbers::pi / 180;

constexpr std::string_view pose_form =
    "N=X,Y,Z, N=X,Y,Z,AX,AY,AZ,DEGREES (turned about that axis), or N= and the 12 numbers of a row "
    "of a pose file";
constexpr std::string_view motion_form =
    "N=spin:AX,AY,AZ,DEGREES_PER_SECOND, N=rock:AX,AY,AZ,DEGREES,SECONDS or "
    "N=swing:DX,DY,DZ,SECONDS";
constexpr std::string_view material_form = "N=K, N=K,B or N=K,B,MU";

/// "N=rest"
struct Numbered {
    std::size_t object = 0;
    std::string_view rest;
};

std::optional<Numbered> split_number(std::string_view text)
{
    Numbered result;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), result.object);
    if (error != std::errc() || end == text.data() + text.size() || *end != '=')
        return std::nullopt;
    result.rest = text.substr(static_cast<std::size_t>(end - text.data()) + 1);
    return result;
}

tl::unexpected<Error> no_such(const char* what, std::string_view text, std::string_view form)
{
    return fail(ErrorCode::invalid_argument, concat("'", text, "' is no ", what, ": give ", form));
}

Result<RigidTransform> parse_pose(std::string_view text)
{
    const auto numbered = split_number(text);
    const auto numbers = numbered ? parse_finite_numbers(numbered->rest) : std::nullopt;
    if (!numbers) return no_such("pose", text, pose_form);
    const std::vector<double>& n = *numbers;
    if (n.size() == 12) {
        const auto pose = make_rigid_transform(std::span<const double, 12>(n.data(), 12));
        if (pose) return *pose;
        return fail(pose.error().code, concat("'", text, "': ", pose.error().message));
    }
    if (n.size() != 3 && n.size() != 7) return no_such("pose", text, pose_form);
    RigidTransform pose;
    pose.translation = Vec3(n[0], n[1], n[2]);
    if (n.size() == 7) {
        const Vec3 axis(n[3], n[4], n[5]);
        if (!(axis.norm() > 0) || !std::isfinite(axis.norm())) {
            return fail(ErrorCode::invalid_argument,
                        concat("'", text, "': the axis of a pose has a length"));
        }
        const double angle = std::fmod(n[6], 360.0) * radians_per_degree;
        pose.rotation = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    }
    return pose;
}

Result<ObjectScript> parse_motion(std::string_view text)
{
    struct Form {
        std::string_view name;
        ObjectMotionKind kind;
        std::size_t numbers;
    };
    constexpr std::array<Form, 3> forms = {{{"spin:", ObjectMotionKind::spin, 4},
                                            {"rock:", ObjectMotionKind::rock, 5},
                                            {"swing:", ObjectMotionKind::swing, 4}}};
    const auto numbered = split_number(text);
    if (!numbered) return no_such("motion", text, motion_form);
    for (const Form& form : forms) {
        if (!numbered->rest.starts_with(form.name)) continue;
        const auto numbers = parse_finite_numbers(numbered->rest.substr(form.name.size()));
        if (!numbers || numbers->size() != form.numbers) break;
        ObjectScript script;
        script.kind = form.kind;
        script.along = Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
        if (form.kind != ObjectMotionKind::swing) script.angle = (*numbers)[3] * radians_per_degree;
        if (form.kind != ObjectMotionKind::spin) script.seconds = numbers->back();
        if (const Status status = check_script(script); !status)
            return fail(status.error().code, concat("'", text, "': ", status.error().message));
        return script;
    }
    return no_such("motion", text, motion_form);
}

Result<SurfaceMaterial> parse_material(std::string_view text, SurfaceMaterial material)
{
    const auto numbered = split_number(text);
    const auto numbers = numbered ? parse_finite_numbers(numbered->rest) : std::nullopt;
    const bool right = numbers && numbers->size() <= 3 &&
                       std::ranges::all_of(*numbers, [](double x) { return x >= 0; });
    if (!right) return no_such("material", text, material_form);
    material.stiffness = (*numbers)[0];
    if (numbers->size() > 1) material.damping = (*numbers)[1];
    if (numbers->size() > 2) {
        material.static_friction = (*numbers)[2];
        material.dynamic_friction = 0.75 * (*numbers)[2];
    }
    return material;
}

/// One value for each time that the option is given.
template <class Parse>
void add_numbered(CLI::App& parser, const std::string& name, std::vector<std::string>& texts,
                  const std::string& help, const Parse& parse, const std::string& type)
{
    parser.add_option(name, texts, help)
        ->allow_extra_args(false)
        ->check([parse](const std::string& text) {
            const auto parsed = parse(text);
            return parsed ? std::string() : parsed.error().message;
        })
        ->type_name(type);
}

/// Gives each text to the object whose number it begins with.
template <class Take>
Status give(const std::vector<std::string>& texts, std::size_t objects, const char* option,
            const Take& take)
{
    std::vector<bool> given(objects, false);
    for (const std::string& text : texts) {
        const std::size_t object = split_number(text)->object;
        if (object >= objects) {
            return fail(ErrorCode::invalid_argument,
                        concat("'", text, "': there is no object ", object, ", they are 0 to ",
                               objects - 1, ": 0 is MODEL, --object adds others"),
                        option);
        }
        if (given[object]) {
            return fail(ErrorCode::invalid_argument, concat("is given twice for object ", object),
                        option);
        }
        given[object] = true;
        take(object, text);
    }
    return {};
}

std::vector<std::string> all_models(const std::string& model, const ObjectOptions& options)
{
    std::vector<std::string> models = {model};
    models.insert(models.end(), options.models.begin(), options.models.end());
    return models;
}

Result<std::unique_ptr<const TouchBody>>
load_body(const std::string& name, const TouchBodyOptions& options, Session& session)
{
    if (is_proximity_file(name)) {
        auto octree = load_proximity_file(name, session);
        if (!octree) return tl::unexpected(octree.error());
        const ProgressBar shown(session.progress(), session.bar());
        auto body = build_touch_body(std::move(*octree), options);
        if (!body && body.error().code == ErrorCode::broken_invariant)
            return fail(ErrorCode::malformed_file, describe(body.error()), name);
        if (!body) return at_model(body.error(), name);
        return body;
    }
    auto mesh = session.load_model(name);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    auto body = build_touch_body(std::move(*mesh), options);
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

void add_object_options(CLI::App& parser, ObjectOptions& options)
{
    parser
        .add_option("--object", options.models,
                    "Another MODEL to touch; again for more. They are numbered: MODEL is 0")
        ->allow_extra_args(false)
        ->type_name("MODEL");
    add_numbered(parser, "--pose", options.poses,
                 concat("Where object N stands at first: ", pose_form), parse_pose, "N=POSE");
    add_numbered(parser, "--motion", options.motions, concat("How object N moves: ", motion_form),
                 parse_motion, "N=MOTION");
    add_numbered(
        parser, "--material", options.materials,
        concat("Stiffness, damping and static friction of object N: ", material_form),
        [](const std::string& text) { return parse_material(text, {}); }, "N=K,B,MU");
}

Result<ScenePlan> plan_scene(const std::string& model, const ObjectOptions& options,
                             const SurfaceMaterial& usual)
{
    ScenePlan plan;
    plan.models = all_models(model, options);
    const std::size_t count = plan.models.size();
    if (count > max_scene_objects) {
        return fail(ErrorCode::invalid_argument,
                    concat("a scene has at most ", max_scene_objects, " objects"), "--object");
    }
    plan.objects.resize(count);
    Status status = give(options.poses, count, "--pose", [&](std::size_t i, const auto& text) {
        plan.objects[i].pose = *parse_pose(text);
    });
    if (status) {
        status = give(options.motions, count, "--motion", [&](std::size_t i, const auto& text) {
            plan.objects[i].script = *parse_motion(text);
        });
    }
    if (status) {
        status = give(options.materials, count, "--material", [&](std::size_t i, const auto& text) {
            plan.objects[i].material = *parse_material(text, usual);
        });
    }
    if (!status) return tl::unexpected(status.error());
    return plan;
}

Result<ScenePlan> plan_scene(const std::string& model, const ObjectOptions& options,
                             const Recording& recording, const std::string& path)
{
    struct Given {
        const char* option;
        bool given;
    };
    for (const auto& [option, given] :
         {Given{"--pose", !options.poses.empty()}, Given{"--motion", !options.motions.empty()},
          Given{"--material", !options.materials.empty()}}) {
        if (!given) continue;
        return fail(ErrorCode::invalid_argument,
                    concat("is in the recording ", path, " already: leave it out"), option);
    }
    ScenePlan plan;
    plan.models = all_models(model, options);
    plan.objects = recording.settings.objects;
    const std::size_t count = std::max<std::size_t>(plan.objects.size(), 1);
    if (plan.models.size() != count) {
        return fail(ErrorCode::invalid_argument,
                    concat("has ", count, count == 1 ? " object" : " objects", ", ",
                           plan.models.size(),
                           " are given: MODEL and then --object for each, in "
                           "their order"),
                    path);
    }
    return plan;
}

Result<std::unique_ptr<TouchModel>> load_touch_scene(const ScenePlan& plan, ForceShading shading,
                                                     const std::string& path, Session& session)
{
    const Stopwatch watch;
    auto model = std::make_unique<TouchModel>();
    std::vector<ScriptedObject> objects = plan.objects;
    std::vector<std::unique_ptr<const TouchBody>> bodies;
    std::uint32_t triangles = 0;
    for (std::size_t i = 0; i < plan.models.size(); ++i) {
        auto body = load_body(plan.models[i],
                              {.material = objects[i].material,
                               .shading = shading,
                               .threads = session.threads(),
                               .progress = &session.progress()},
                              session);
        if (!body) return tl::unexpected(body.error());
        const std::uint64_t fingerprint = (*body)->octree().mesh_fingerprint();
        if (objects[i].mesh_fingerprint != 0 && objects[i].mesh_fingerprint != fingerprint) {
            return fail(ErrorCode::invalid_argument,
                        concat("was recorded with another model as object ", i, " than ",
                               plan.models[i], ": replay it with the ones that were touched"),
                        path);
        }
        objects[i].mesh_fingerprint = fingerprint;
        model->parts.push_back(triangles);
        triangles += static_cast<std::uint32_t>((*body)->mesh().triangle_count());
        bodies.push_back(std::move(*body));
    }
    auto scene = ScriptedScene::make(std::move(bodies), objects);
    if (!scene) return tl::unexpected(scene.error());
    model->scene = std::move(*scene);
    auto mesh = standing_mesh(model->scene->scene());
    if (!mesh) return tl::unexpected(mesh.error());
    auto surface = surface_of(std::move(*mesh), plan.models.front(), session);
    if (!surface) return tl::unexpected(surface.error());
    model->surface = std::move(*surface);
    model->object_names = plan.models;
    model->reach = model->scene->reach();
    model->build_seconds = watch.seconds();
    return model;
}

std::string objects_text(const TouchModel& model, const QualityReport& quality)
{
    if (model.scene == nullptr) return {};
    std::string text =
        fmt::format("{} objects, moving in {} ticks, leaving no room in {}\n",
                    quality.objects.size(), quality.moving_ticks, quality.squeezed_ticks);
    for (std::size_t i = 0; i < quality.objects.size(); ++i) {
        const ObjectQuality& object = quality.objects[i];
        const SceneObject there =
            model.scene->scene().object(ObjectId{static_cast<std::uint32_t>(i)});
        text += fmt::format(
            "  {} {}: {} triangles, {}; touched in {} ticks, surface at most {:.3f} "
            "m/s\n",
            i, model.object_names[i], there.body->mesh().triangle_count(),
            words_of(model.scene->objects()[i].script), object.touching_ticks, object.max_carrying);
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
            model.scene->scene().object(ObjectId{static_cast<std::uint32_t>(i)});
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
                        {"touching_ticks", object.touching_ticks},
                        {"moving_ticks", object.moving_ticks},
                        {"max_carrying", object.max_carrying}});
    }
    return rows;
}

} // namespace proxima
