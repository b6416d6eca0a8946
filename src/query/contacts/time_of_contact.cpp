#include "proxima/time_of_contact.h"

#include "base/check.h"
#include "geometry/length.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "query/contacts/first_contact.h"

#include <algorithm>
#include <limits>

namespace proxima {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

ContactEvidence evidence_of(SearchEnd end)
{
    switch (end) {
    case SearchEnd::rounding:
        return ContactEvidence::rounding;
    case SearchEnd::steps:
        return ContactEvidence::steps;
    case SearchEnd::cancelled:
        return ContactEvidence::cancelled;
    case SearchEnd::free:
    case SearchEnd::meets:
        break;
    }
    return ContactEvidence::intersection;
}

/// A time at which they meet, within the tolerance or a little later, where roundings hide less and less;
/// infinity where they do not.
double meeting_after(const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion, double time,
                     double tolerance, double rounding)
{
    MeshMeeting meeting;
    const auto meets_at = [&](double within) {
        const double probe = std::min(1.0, std::max(time + within, std::nextafter(time, 2.0)));
        if (find_meeting(a, b, pose_at(motion, probe), {.start_from = &meeting})) return probe;
        return never;
    };
    const double at_once = meets_at(tolerance);
    constexpr double latest = 0x1p-10;
    const double last = std::max(latest, 64 * rounding);
    for (double within = 4 * rounding; within <= last && time + within < at_once; within *= 4) {
        if (const double found = meets_at(within); found < never) return found;
        if (time + within >= 1) break;
    }
    return at_once;
}

/// Fills in what is known of B at a time. If the progress is cancelled, the distance stays infinite.
void place(TimeOfContact& answer, const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion,
           const FirstContact& found, const Progress* progress)
{
    answer.free_until = found.free_until;
    answer.free_pose = pose_at(motion, found.free_until);
    const MeshDistance hint = {.row_a = found.row_a, .row_b = found.row_b};
    const MeshDistance nearest =
        mesh_distance(a, b, answer.free_pose, {.start_from = &hint, .progress = progress})
            .value_or(MeshDistance{});
    answer.distance = nearest.distance;
    answer.point_a = nearest.point_a;
    answer.point_b = nearest.point_b;
    answer.triangle_a = nearest.triangle_a;
    answer.triangle_b = nearest.triangle_b;
    answer.normal = found.normal;
    if (answer.normal.isZero(0) && nearest.distance > 0)
        answer.normal = unit_of(nearest.point_b - nearest.point_a);
}

} // namespace

std::optional<TimeOfContact> time_of_contact(const MeshIndex& a, const MeshIndex& b,
                                             const RigidMotion& motion,
                                             const TimeOfContactOptions& options) noexcept
{
    if (a.triangle_count() == 0 || b.triangle_count() == 0) return std::nullopt;
    PROXIMA_CHECK(length_of(motion.turn) <= max_motion_turn);
    TimeOfContact answer;
    if (meshes_intersect(a, b, motion.start)) {
        place(answer, a, b, motion, {.free_until = 0}, options.execution.progress);
        return answer;
    }
    FirstContactSearch search(a.parts(), b.parts(), motion, options);
    const FirstContact found = search.find();
    if (found.end == SearchEnd::free) return std::nullopt;
    answer.steps = found.steps;
    answer.evidence = evidence_of(found.end);
    answer.touches_at = never;
    if (found.end == SearchEnd::meets) answer.touches_at = found.meets_at;
    if (found.end == SearchEnd::rounding) {
        answer.touches_at = meeting_after(a, b, motion, found.free_until, search.tolerance(),
                                          search.bounds().rounding());
        if (answer.touches_at < never) answer.evidence = ContactEvidence::intersection;
    }
    place(answer, a, b, motion, found, options.execution.progress);
    return answer;
}

} // namespace proxima
