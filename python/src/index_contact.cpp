#include "arrays.h"
#include "contour.h"
#include "index_methods.h"
#include "proxima/intersect_meshes.h"
#include "run.h"

#include <string>
#include <vector>

namespace proxima::python {

namespace {

py::array first_of_pairs(std::span<const TrianglePair> pairs)
{
    auto array = new_array<std::int32_t>(pairs.size());
    std::int32_t* to = array.mutable_data();
    for (const TrianglePair& pair : pairs) *to++ = static_cast<std::int32_t>(to_index(pair.a));
    return array;
}

py::array second_of_pairs(std::span<const TrianglePair> pairs)
{
    auto array = new_array<std::int32_t>(pairs.size());
    std::int32_t* to = array.mutable_data();
    for (const TrianglePair& pair : pairs) *to++ = static_cast<std::int32_t>(to_index(pair.b));
    return array;
}

py::object self_intersections(const MeshIndex& index, Integer max_pairs, Integer threads,
                              const py::object& progress)
{
    const Threads thread_count = threads_of(threads);
    const std::size_t most = count_of(max_pairs, "max_pairs");
    const SelfIntersections found = run(progress, Duration::lengthy, [&](Progress* watched) {
        return find_self_intersections(
            index,
            {.max_pairs = most, .execution = {.threads = thread_count, .progress = watched}});
    });
    return result_type("SelfIntersections")(first_of_pairs(found.pairs),
                                            second_of_pairs(found.pairs), found.complete);
}

Result<Enclosure> enclosure_of(const MeshIndex& index, Progress* progress)
{
    return build_enclosure(index, {.execution = {.progress = progress}});
}

py::object containment(const MeshIndex& index, const MeshIndex& other, const py::object& poses,
                       const py::object& progress)
{
    const Poses moved = poses_of(poses);
    auto which = new_array<std::uint8_t>(moved.poses.size());
    auto methods = new_array<std::uint8_t>(moved.poses.size());
    std::uint8_t* const answer = which.mutable_data();
    std::uint8_t* const method = methods.mutable_data();
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        const auto a = enclosure_of(index, watched);
        if (!a) return tl::unexpected(a.error());
        const auto b = enclosure_of(other, watched);
        if (!b) return tl::unexpected(b.error());
        watched->begin_stage("containment", moved.poses.size());
        for (std::size_t i = 0; i < moved.poses.size(); ++i) {
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            const ContainmentAnswer found = find_containment(*a, *b, moved.poses[i]);
            answer[i] = static_cast<std::uint8_t>(found.containment);
            method[i] = static_cast<std::uint8_t>(found.method);
            watched->advance(1);
        }
        return {};
    });
    const ResultType type = result_type("Containments");
    if (!moved.single) return type(which, methods);
    return type(int{answer[0]}, int{method[0]});
}

py::array contains(const MeshIndex& index, const py::object& points, const py::object& progress)
{
    const PointsArgument argument(points, "points");
    auto inside = new_array<bool>(argument.size());
    bool* const answer = inside.mutable_data();
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        const auto enclosure = enclosure_of(index, watched);
        if (!enclosure) return tl::unexpected(enclosure.error());
        watched->begin_stage("points inside", argument.size());
        for (std::size_t i = 0; i < argument.size(); ++i) {
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            const Vec3& p = argument.points()[i];
            if (!p.allFinite()) {
                return fail(ErrorCode::invalid_argument,
                            "point " + std::to_string(i) + " is not finite: leave it out",
                            "points");
            }
            answer[i] = encloses(*enclosure, {}, p);
            watched->advance(1);
        }
        return {};
    });
    return inside;
}

/// Columns of one surface's parts.
struct PartColumns {
    explicit PartColumns(std::size_t size)
        : kind(new_array<std::uint8_t>(size)), ids(new_rows<std::int32_t>(size, 2))
    {}

    void set(std::size_t row, const SurfacePart& part)
    {
        kind.mutable_data()[row] = static_cast<std::uint8_t>(part.kind);
        for (std::size_t k = 0; k < 2; ++k)
            ids.mutable_data()[2 * row + k] = static_cast<std::int32_t>(part.ids[k]);
    }

    py::array_t<std::uint8_t> kind;
    py::array_t<std::int32_t> ids;
};

py::object contour(const MeshIndex& index, const MeshIndex& other, const py::object& pose,
                   const py::object& progress)
{
    const RigidTransform moved = pose_of(pose);
    return contour_columns(run(progress, Duration::lengthy, [&](Progress* watched) {
        return intersection_contour(index, other, moved, {{.progress = watched}});
    }));
}

} // namespace

py::object contour_columns(const IntersectionContour& contour)
{
    const std::size_t size = contour.points.size();
    auto points = new_rows<double>(size, 3);
    PartColumns on_a(size);
    PartColumns on_b(size);
    for (std::size_t i = 0; i < size; ++i) {
        elements_of<Vec3>(points)[i] = contour.points[i].position;
        on_a.set(i, contour.points[i].on_a);
        on_b.set(i, contour.points[i].on_b);
    }
    auto first = new_array<std::int64_t>(contour.lines.size() + 1);
    auto closed = new_array<bool>(contour.lines.size());
    first.mutable_data()[0] = 0;
    for (std::size_t i = 0; i < contour.lines.size(); ++i) {
        first.mutable_data()[i + 1] =
            static_cast<std::int64_t>(contour.lines[i].first + contour.lines[i].count);
        closed.mutable_data()[i] = contour.lines[i].closed;
    }
    return result_type("Contour")(first, closed, points, on_a.kind, on_a.ids, on_b.kind, on_b.ids,
                                  contour.length());
}

void bind_contact(py::class_<MeshIndex>& index)
{
    index
        .def(
            "self_intersections", &self_intersections, py::kw_only(),
            py::arg("max_pairs") = SelfIntersectionOptions{}.max_pairs, py::arg("threads") = 0,
            py::arg("progress") = py::none(),
            R"(The pairs of triangles of this mesh that meet in more than what they share, as SelfIntersections.

    max_pairs  stops where more were found

Exact. Corners at one position are shared, whatever their ids. About 5 us per triangle of a scanned model.)")
        .def(
            "containment", &containment, py::arg("other"), py::arg("poses") = py::none(),
            py::kw_only(), py::arg("progress") = py::none(),
            R"(Whether one mesh lies inside the other, moved by poses as in intersect(), as Containments.

Ask intersect() first: where the surfaces meet, the answer means nothing. Exact for closed meshes; of open ones winding
numbers decide. Each call finds out how both insides are told, up to 1 us per triangle.)")
        .def(
            "contains", &contains, py::arg("points"), py::kw_only(),
            py::arg("progress") = py::none(),
            R"((n,) bool: whether points (n, 3) lie inside of the mesh. On the surface it may say either.

Exact for closed meshes, whichever way they face; of open ones winding numbers decide. Needs no signs. Up to 1 us per
triangle for each call, and 6 us per point on a scan of 70,000 triangles.)")
        .def(
            "contour", &contour, py::arg("other"), py::arg("pose") = py::none(), py::kw_only(),
            py::arg("progress") = py::none(),
            R"(The lines along which this surface and another one, moved by a pose (3, 4) or (4, 4), meet, as a Contour.

Those of closed meshes that pass through each other are closed. Exact but for the rounding of points. About 4 us per pair of
triangles that meet.)");
}

} // namespace proxima::python
