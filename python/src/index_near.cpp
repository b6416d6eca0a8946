#include "arrays.h"
#include "index_methods.h"
#include "proxima/neighbourhood.h"
#include "run.h"

#include <algorithm>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

py::object within(const MeshIndex& index, const py::object& points, double radius,
                  const py::object& progress)
{
    const PointsArgument argument(points, "points");
    if (!(radius >= 0)) refuse("radius", "must be 0 or more");
    std::vector<std::size_t> first{0};
    std::vector<TriangleId> triangles;
    run(progress, duration_of(argument.size()), [&](Progress* watched) -> Status {
        if (watched != nullptr) watched->begin_stage("triangles within", argument.size());
        std::vector<TriangleId> buffer(std::min<std::size_t>(index.triangle_count(), 1024));
        for (std::size_t i = 0; i < argument.size(); ++i) {
            const Vec3& p = argument.points()[i];
            if (!p.allFinite()) {
                return fail(ErrorCode::invalid_argument,
                            "point " + std::to_string(i) + " is not finite: leave it out",
                            "points");
            }
            Neighbourhood found = collect_triangles(index, p, radius, buffer);
            if (!found.complete) {
                buffer.resize(index.triangle_count());
                found = collect_triangles(index, p, radius, buffer);
            }
            triangles.insert(triangles.end(), buffer.begin(),
                             buffer.begin() + static_cast<std::ptrdiff_t>(found.written));
            first.push_back(triangles.size());
            if (watched == nullptr) continue;
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            watched->advance(1);
        }
        return {};
    });
    return result_type("Neighbours")(
        array_of<std::int64_t>(std::span<const std::size_t>(first)),
        array_of<std::int32_t>(std::span<const TriangleId>(triangles)));
}

} // namespace

void bind_near(py::class_<MeshIndex>& index)
{
    index.def("within", &within, py::arg("points"), py::arg("radius"), py::kw_only(),
              py::arg("progress") = py::none(),
              "The triangles within a radius of points (n, 3), in the mesh's unit, as Neighbours.");
}

} // namespace proxima::python
