#include "arrays.h"
#include "index_methods.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "run.h"

#include <vector>

namespace proxima::python {

namespace {

py::object intersect(const MeshIndex& index, const MeshIndex& other, const py::object& poses,
                     bool pairs, Integer threads, const py::object& progress)
{
    const Poses moved = poses_of(poses);
    const Threads thread_count = threads_of(threads);
    const auto options_for = [&](Progress* watched) {
        return PairOptions{.execution = {.threads = thread_count, .progress = watched}};
    };
    if (!pairs) {
        auto answers = new_array<bool>(moved.poses.size());
        run(progress, Duration::lengthy, [&](Progress* watched) {
            return meshes_intersect(index, other, moved.poses, elements_of<bool>(answers),
                                    options_for(watched));
        });
        if (moved.single) return py::bool_(answers.at(0));
        return answers;
    }
    const PairLists lists = run(progress, Duration::lengthy, [&](Progress* watched) {
        return intersecting_pairs(index, other, moved.poses, options_for(watched));
    });
    auto a = new_array<std::int32_t>(lists.pairs.size());
    auto b = new_array<std::int32_t>(lists.pairs.size());
    for (std::size_t i = 0; i < lists.pairs.size(); ++i) {
        a.mutable_data()[i] = static_cast<std::int32_t>(to_index(lists.pairs[i].a));
        b.mutable_data()[i] = static_cast<std::int32_t>(to_index(lists.pairs[i].b));
    }
    if (moved.single) return result_type("Pairs")(a, b);
    return result_type("PairLists")(
        array_of<std::int64_t>(std::span<const std::size_t>(lists.first)), a, b);
}

py::object distance_to(const MeshIndex& index, const MeshIndex& other, const py::object& poses,
                       double farthest, const py::object& progress)
{
    const Poses moved = poses_of(poses);
    check_not_negative(farthest, "farthest");
    const std::size_t count = moved.poses.size();
    auto distance = new_array<double>(count);
    auto point_a = new_rows<double>(count, 3);
    auto point_b = new_rows<double>(count, 3);
    auto triangle_a = new_array<std::int32_t>(count);
    auto triangle_b = new_array<std::int32_t>(count);
    const auto points_a = elements_of<Vec3>(point_a);
    const auto points_b = elements_of<Vec3>(point_b);
    double* const distances = distance.mutable_data();
    const auto triangles_a = elements_of<TriangleId>(triangle_a);
    const auto triangles_b = elements_of<TriangleId>(triangle_b);
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        watched->begin_stage("distances between meshes", count);
        const MeshDistance none{infinity, Vec3::Constant(nan), Vec3::Constant(nan), no_triangle,
                                no_triangle};
        MeshDistance last;
        for (std::size_t i = 0; i < count; ++i) {
            const auto found = mesh_distance(index, other, moved.poses[i],
                                             {.farthest = farthest,
                                              .start_from = i == 0 ? nullptr : &last,
                                              .progress = watched});
            if (watched->cancelled())
                return fail(ErrorCode::cancelled, "the search for distances was cancelled");
            const MeshDistance& answer = found ? *found : none;
            if (found) last = *found;
            distances[i] = answer.distance;
            points_a[i] = answer.point_a;
            points_b[i] = answer.point_b;
            triangles_a[i] = answer.triangle_a;
            triangles_b[i] = answer.triangle_b;
            watched->advance(1);
        }
        return {};
    });
    const ResultType type = result_type("Distances");
    if (!moved.single) return type(distance, point_a, point_b, triangle_a, triangle_b);
    const py::int_ first(0);
    return type(distance[first], point_a[first], point_b[first], triangle_a[first],
                triangle_b[first]);
}

} // namespace

void bind_pairs(py::class_<MeshIndex>& index)
{
    index
        .def("intersect", &intersect, py::arg("other"), py::arg("poses") = py::none(),
             py::kw_only(), py::arg("pairs") = true, py::arg("threads") = 0,
             py::arg("progress") = py::none(),
             R"(Where this mesh and another one, moved by poses, meet. Exact; touching counts.

    poses  None, (3, 4) or (4, 4), or (n, 3, 4) or (n, 4, 4) floats: rigid, row-major, applied to `other`
    pairs  True: the pairs of triangles that meet, Pairs for one pose, PairLists for several; False: bool or (n,) bool)")
        .def(
            "distance_to", &distance_to, py::arg("other"), py::arg("poses") = py::none(),
            py::kw_only(), py::arg("farthest") = infinity, py::arg("progress") = py::none(),
            R"(How far this surface and another one, moved by poses as in intersect(), are apart, as Distances.

0 if and only if they touch. Beyond `farthest`, in the mesh's unit, nothing is found.)");
}

} // namespace proxima::python
