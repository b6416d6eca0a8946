// proxima contact-time: when a moving mesh first touches another one.
#include "base/text.h"
#include "cli/commands.h"
#include "cli/index_file_model.h"
#include "cli/json_numbers.h"
#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/number_checks.h"
#include "cli/poses.h"
#include "cli/stopwatch.h"
#include "proxima/mesh_index.h"
#include "proxima/time_of_contact.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <vector>

namespace proxima {

namespace {

using Json = nlohmann::ordered_json;

struct ContactTimeOptions {
    std::string model_a;
    std::string model_b;
    std::string from;
    std::string to;
    std::string center;
    std::string turn;
    TimeOfContactOptions search;
};

struct MovingModel {
    TriangleMesh mesh;
    MeshIndex index; ///< with slabs
};

Result<MovingModel> load_moving(const std::string& model, Session& session)
{
    auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    const ProgressBar shown(session.progress(), session.bar());
    auto index = index_of_model(model, *mesh, session);
    if (!index) return tl::unexpected(index.error());
    if (!index->has_slabs()) index = with_slabs(*index, {.execution = session.execution()});
    if (!index) return at_model(index.error(), model);
    return MovingModel{std::move(*mesh), *index};
}

/// The identity without a text.
Result<Poses> one_pose(const std::string& text, std::string_view option, Session& session)
{
    if (text.empty()) return Poses{.poses = std::vector<RigidTransform>(1)};
    auto poses = read_poses(text, session);
    if (!poses || poses->poses.size() == 1) return poses;
    return fail(ErrorCode::invalid_argument,
                concat("takes one pose, and ", text, " has ", poses->poses.size()),
                std::string(option));
}

Result<Vec3> three_numbers(const std::string& text, std::string_view option)
{
    const auto numbers = parse_finite_numbers(text);
    if (numbers && numbers->size() == 3) return Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
    return fail(ErrorCode::invalid_argument, concat(text, " is not X,Y,Z"), std::string(option));
}

struct GivenMotion {
    RigidMotion motion;
    double rotation_error = 0; ///< of the pose that was farthest from a rotation
};

/// The motion of the options: from one pose to the other, about the middle of B's box or as given, by
/// the shorter turn or as given.
Result<GivenMotion> motion_of(const ContactTimeOptions& options, const TriangleMesh& mesh_b,
                              Session& session)
{
    const auto from = one_pose(options.from, "--from", session);
    if (!from) return tl::unexpected(from.error());
    const auto to = one_pose(options.to, "--to", session);
    if (!to) return tl::unexpected(to.error());
    Vec3 center = bounding_box(mesh_b).center();
    if (!options.center.empty()) {
        const auto given = three_numbers(options.center, "--center");
        if (!given) return tl::unexpected(given.error());
        center = *given;
    }
    RigidMotion motion = motion_between(from->poses.front(), to->poses.front(), center);
    if (!options.turn.empty()) {
        const auto numbers = parse_finite_numbers(options.turn);
        const bool is_turn = numbers && numbers->size() == 4;
        const Vec3 axis =
            is_turn ? Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]) : Vec3::Zero();
        if (!is_turn || axis.isZero(0)) {
            return fail(
                ErrorCode::invalid_argument,
                concat(options.turn, " is not AX,AY,AZ,DEGREES with an axis that is not zero"),
                "--turn");
        }
        motion.turn = axis.stableNormalized() * ((*numbers)[3] / 180 * std::numbers::pi);
    }
    if (Status status = check_motion(motion); !status) return tl::unexpected(status.error());
    return GivenMotion{motion, std::max(from->rotation_error, to->rotation_error)};
}

std::string_view name_of(ContactEvidence evidence)
{
    return evidence == ContactEvidence::intersection ? "intersection"
           : evidence == ContactEvidence::rounding   ? "rounding"
                                                     : "steps";
}

Json json_of(const std::optional<TimeOfContact>& found)
{
    Json json = {{"contact", found.has_value()}};
    if (!found) return json;
    json["evidence"] = name_of(found->evidence);
    json["free_until"] = found->free_until;
    json["touches_at"] = std::isfinite(found->touches_at) ? Json(found->touches_at) : Json();
    Json pose = Json::array();
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) pose.push_back(found->free_pose.rotation(i, k));
        pose.push_back(found->free_pose.translation[i]);
    }
    json["free_pose"] = pose;
    json["distance"] = found->distance;
    json["point_a"] = json_numbers(found->point_a);
    json["point_b"] = json_numbers(found->point_b);
    json["triangle_a"] = to_index(found->triangle_a);
    json["triangle_b"] = to_index(found->triangle_b);
    json["normal"] = json_numbers(found->normal);
    json["steps"] = found->steps;
    return json;
}

std::string text_of(const std::optional<TimeOfContact>& found)
{
    if (!found) return "no contact from time 0 to 1";
    const auto triple = [](const Vec3& p) {
        return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x() + 0.0, p.y() + 0.0, p.z() + 0.0);
    };
    std::string text;
    if (found->evidence == ContactEvidence::intersection) {
        text = fmt::format("free until {:.12g}, touches at {:.12g}", found->free_until,
                           found->touches_at);
    } else {
        text = fmt::format("free until {:.12g}; no contact is shown, {}", found->free_until,
                           found->evidence == ContactEvidence::rounding
                               ? "and roundings of the coordinates hide whether there is one"
                               : "and the steps are used up");
    }
    return text +
           fmt::format("\nthen {:.3g} apart: triangle {} at {}, triangle {} at {}\nnormal {}; "
                       "{} steps",
                       found->distance, to_index(found->triangle_a), triple(found->point_a),
                       to_index(found->triangle_b), triple(found->point_b), triple(found->normal),
                       found->steps);
}

Status run_contact_time(const ContactTimeOptions& options, Session& session)
{
    if (Status status = session.check_outputs({}); !status) return status;
    const Stopwatch build_watch;
    const auto a = load_moving(options.model_a, session);
    if (!a) return tl::unexpected(a.error());
    const auto b = load_moving(options.model_b, session);
    if (!b) return tl::unexpected(b.error());
    const double build_seconds = build_watch.seconds();
    const auto given = motion_of(options, b->mesh, session);
    if (!given) return tl::unexpected(given.error());
    const RigidMotion& motion = given->motion;
    TimeOfContactOptions search = options.search;
    search.execution = session.execution();
    const Stopwatch watch;
    const auto found = [&] {
        const ProgressBar shown(session.progress(), session.bar());
        return time_of_contact(a->index, b->index, motion, search);
    }();
    const double seconds = watch.seconds();
    if (Status status = session.check_running(); !status) return status;
    const std::string rotated = rotation_text(given->rotation_error, true, session);
    session.print(fmt::format("A {}: {} triangles\nB {}: {} triangles\n{}{}, {:.3f} ms\n",
                              options.model_a, a->mesh.triangle_count(), options.model_b,
                              b->mesh.triangle_count(), rotated, text_of(found), 1e3 * seconds));
    Json json = {{"a", options.model_a},
                 {"b", options.model_b},
                 {"triangles_a", a->mesh.triangle_count()},
                 {"triangles_b", b->mesh.triangle_count()},
                 {"build_seconds", build_seconds},
                 {"rotation_error", given->rotation_error},
                 {"center", json_numbers(motion.center)},
                 {"displacement", json_numbers(motion.displacement)},
                 {"turn", json_numbers(motion.turn)}};
    json.update(json_of(found));
    json["seconds"] = seconds;
    return session.write_json(json);
}

} // namespace

Command add_contact_time_command(CLI::App& app)
{
    CLI::App* const parser = app.add_subcommand(
        "contact-time", "Find when a mesh that moves rigidly first touches another one");
    const auto options = std::make_shared<ContactTimeOptions>();
    parser->add_option("A", options->model_a, "The mesh that stands still: a file or a built-in")
        ->required()
        ->type_name("MODEL");
    parser->add_option("B", options->model_b, "The mesh that moves")
        ->required()
        ->type_name("MODEL");
    parser
        ->add_option("--from", options->from,
                     concat("B's pose at time 0, the identity without it. A pose is ", pose_forms))
        ->type_name("POSE");
    parser->add_option("--to", options->to, "B's pose at time 1")->required()->type_name("POSE");
    parser
        ->add_option("--center", options->center,
                     "The point of B, in its own coordinates, that moves along a straight line "
                     "(default: the middle of its box)")
        ->type_name("X,Y,Z");
    parser
        ->add_option("--turn", options->turn,
                     "Turn about this axis by so many degrees, several revolutions if you like, "
                     "instead of the shorter turn from --from to --to")
        ->type_name("AX,AY,AZ,DEGREES");
    parser
        ->add_option("--tolerance", options->search.tolerance,
                     "Of the time: how far apart free_until and touches_at may be")
        ->check(number_between(0.0, 1.0))
        ->capture_default_str()
        ->type_name("T");
    parser
        ->add_option("--max-steps", options->search.max_steps,
                     "Steps at most, about 1 us each: parts that are divided, steps of triangles")
        ->check(CLI::Range(1U, 1000000000U))
        ->capture_default_str()
        ->type_name("N");
    return {parser, [options](Session& session) { return run_contact_time(*options, session); }};
}

} // namespace proxima
