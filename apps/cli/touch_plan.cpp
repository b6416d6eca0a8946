#include "cli/touch_plan.h"

#include "base/text.h"
#include "cli/names.h"
#include "cli/poses.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace proxima {

namespace {

constexpr std::string_view motion_form =
    "N=spin:AX,AY,AZ,DEGREES_PER_SECOND, N=rock:AX,AY,AZ,DEGREES,SECONDS or "
    "N=swing:DX,DY,DZ,SECONDS";
constexpr std::string_view material_form = "N=K, N=K,B or N=K,B,MU, numbers from 0 to 1e9";
constexpr double most_of_a_material = 1e9; ///< as in a recording

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

Result<Poses> parse_object_pose(std::string_view text)
{
    const auto numbered = split_number(text);
    if (!numbered) return no_such("pose", text, concat("N=POSE; POSE is ", pose_forms));
    return parse_pose(numbered->rest);
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
    const bool right =
        numbers && numbers->size() <= 3 &&
        std::ranges::all_of(*numbers, [](double x) { return x >= 0 && x <= most_of_a_material; });
    if (!right) return no_such("material", text, material_form);
    material.stiffness = (*numbers)[0];
    if (numbers->size() > 1) material.damping = (*numbers)[1];
    if (numbers->size() > 2) {
        material.static_friction = (*numbers)[2];
        material.dynamic_friction = 0.75 * (*numbers)[2];
    }
    return material;
}

tl::unexpected<Error> no_object(const std::string& text, std::size_t object, std::size_t objects,
                                const char* option)
{
    return fail(ErrorCode::invalid_argument,
                concat("'", text, "': there is no object ", object, ", they are 0 to ", objects - 1,
                       ": 0 is MODEL, --object adds others"),
                option);
}

/// Whatever object it is of, if of one.
Status check_texture_text(std::string_view text)
{
    const auto numbered = is_of_object(text) ? split_number(text) : std::nullopt;
    if (!numbered && is_of_object(text))
        return no_such("texture", text, concat("TEXTURE or N=TEXTURE; TEXTURE is ", texture_forms));
    return check_effect(numbered ? numbered->rest : text);
}

/// Gives the objects of a plan the textures that are theirs alone, on top of what all have.
Status give_textures(const ObjectOptions& options, ScenePlan& plan)
{
    const TextureImages& images = options.images;
    for (const std::string& text : options.textures) {
        if (!is_of_object(text)) continue;
        const Numbered numbered = *split_number(text);
        if (numbered.object >= plan.objects.size())
            return no_object(text, numbered.object, plan.objects.size(), "--texture");
        auto& texture = plan.objects[numbered.object].texture;
        if (!texture) texture = common_texture(options.textures, images);
        texture = with_effect(*texture, numbered.rest, images);
    }
    return {};
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
        if (object >= objects) return no_object(text, object, objects, option);
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

} // namespace

void add_object_options(CLI::App& parser, ObjectOptions& options)
{
    parser
        .add_option("--object", options.models,
                    "Another MODEL to touch; again for more. They are numbered: MODEL is 0")
        ->allow_extra_args(false)
        ->type_name("MODEL");
    add_numbered(parser, "--pose", options.poses,
                 concat("Where object N stands at first. POSE is ", pose_forms), parse_object_pose,
                 "N=POSE");
    add_numbered(parser, "--motion", options.motions, concat("How object N moves: ", motion_form),
                 parse_motion, "N=MOTION");
    add_numbered(
        parser, "--material", options.materials,
        concat("Stiffness, damping and static friction of object N: ", material_form),
        [](const std::string& text) { return parse_material(text, {}); }, "N=K,B,MU");
    add_numbered(parser, "--texture", options.textures,
                 concat("What the surface feels like, of all objects or of object N; again for "
                        "more: ",
                        texture_forms),
                 check_texture_text, "[N=]TEXTURE");
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
        const Poses pose = *parse_object_pose(text);
        plan.objects[i].pose = pose.poses[0];
        plan.rotation_error = std::max(plan.rotation_error, pose.rotation_error);
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
    if (status) status = give_textures(options, plan);
    if (!status) return tl::unexpected(status.error());
    return plan;
}

Result<ScenePlan> plan_scene(const std::string& model, const ObjectOptions& options,
                             const Recording& recording, const std::string& path)
{
    ScenePlan plan;
    plan.models = all_models(model, options);
    plan.objects = recording.settings.objects;
    plan.room = recording.settings.room;
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

} // namespace proxima
