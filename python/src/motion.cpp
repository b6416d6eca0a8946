#include "arrays.h"
#include "index_methods.h"
#include "proxima/time_of_contact.h"
#include "run.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace proxima::python {

namespace {

RigidMotion motion_of(const py::object& object)
{
    if (!py::isinstance(object, result_type("Motion")))
        refuse_object(object, "motion", "a proxima.Motion");
    RigidMotion motion{.start = pose_of(object.attr("start")),
                       .center = point_of(object.attr("center"), "motion.center"),
                       .displacement = point_of(object.attr("displacement"), "motion.displacement"),
                       .turn = point_of(object.attr("turn"), "motion.turn")};
    value_of(check_motion(motion));
    return motion;
}

py::object between(const py::object& from, const py::object& to, const py::object& center)
{
    const RigidMotion motion =
        motion_between(pose_of(from), pose_of(to), point_of(center, "center"));
    value_of(check_motion(motion));
    return result_type("Motion")(matrix_of(motion.start), vector_of(motion.center),
                                 vector_of(motion.displacement), vector_of(motion.turn));
}

py::object first_contact(const MeshIndex& index, const MeshIndex& other, const py::object& motion,
                         double tolerance, Integer max_steps, const py::object& progress)
{
    const RigidMotion path = motion_of(motion);
    if (!(tolerance >= 0 && tolerance <= 1)) refuse("tolerance", "must be from 0 to 1");
    constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
    TimeOfContactOptions options{
        .tolerance = tolerance,
        .max_steps = static_cast<std::uint32_t>(count_of(max_steps, "max_steps", most, 1))};
    std::optional<TimeOfContact> found;
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        options.execution.progress = watched;
        found = time_of_contact(index, other, path, options);
        if (!found || found->evidence != ContactEvidence::cancelled) return {};
        return fail(ErrorCode::cancelled, "finding the time of contact was cancelled");
    });
    if (!found) return py::none();
    return result_type("FirstContact")(
        found->free_until, found->touches_at, static_cast<int>(found->evidence),
        matrix_of(found->free_pose), found->distance, vector_of(found->point_a),
        vector_of(found->point_b), to_index(found->triangle_a), to_index(found->triangle_b),
        vector_of(found->normal), found->steps);
}

} // namespace

void bind_motions(py::module_& module, py::class_<MeshIndex>& index)
{
    index.def(
        "time_of_contact", &first_contact, py::arg("other"), py::arg("motion"), py::kw_only(),
        py::arg("tolerance") = TimeOfContactOptions{}.tolerance,
        py::arg("max_steps") = TimeOfContactOptions{}.max_steps, py::arg("progress") = py::none(),
        R"(When another mesh, moved along a Motion, first touches this one: a FirstContact, or None.

    tolerance  of the time, 0 to 1: how far both ends of the interval may be apart
    max_steps  the search ends after as many steps, about 1 us each

None is proven for every time from 0 to 1. Contact is that of surfaces; touching counts. Less than a millisecond in the
median, seconds where fine curved surfaces slide along each other. Indexes with distances are faster.)");
    module.def(
        "motion_between", &between, py::arg("start"), py::arg("end"), py::arg("center"),
        R"(The Motion from a pose to another one, (3, 4) or (4, 4) each, by the shorter turn about `center`, (3,).

The center is a point of the moving mesh, in its own coordinates. It moves along a straight line.)");
    module.def(
        "pose_at",
        [](const py::object& motion, double time) {
            const RigidMotion path = motion_of(motion);
            if (!std::isfinite(time)) refuse("time", "must be finite");
            const RigidTransform pose = proxima::pose_at(path, time);
            if (!pose.rotation.allFinite() || !pose.translation.allFinite())
                refuse("time", "the pose then is beyond the largest double");
            return matrix_of(pose);
        },
        py::arg("motion"), py::arg("time"),
        "The pose (3, 4) of a Motion at a time: its start at 0, its end at 1.");
}

} // namespace proxima::python
