#include "arrays.h"
#include "base/memory_budget.h"
#include "index_methods.h"
#include "proxima/function_ref.h"
#include "proxima/neighbourhood.h"
#include "run.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// Calls body(point) for all of them, in order, where Ctrl-C can end it.
void for_each_point(const PointsArgument& points, const py::object& progress, const char* stage,
                    FunctionRef<void(const Vec3&)> body)
{
    run(progress, duration_of(points.size()), [&](Progress* watched) -> Status {
        if (watched != nullptr) watched->begin_stage(stage, points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3& p = points.points()[i];
            if (!p.allFinite()) {
                return fail(ErrorCode::invalid_argument,
                            "point " + std::to_string(i) + " is not finite: leave it out",
                            "points");
            }
            body(p);
            if (watched == nullptr) continue;
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            watched->advance(1);
        }
        return {};
    });
}

py::object within(const MeshIndex& index, const py::object& points, double radius,
                  const py::object& progress)
{
    const PointsArgument argument(points, "points");
    check_not_negative(radius, "radius");
    std::vector<std::size_t> first{0};
    std::vector<TriangleId> triangles;
    std::vector<TriangleId> buffer(std::min<std::size_t>(index.triangle_count(), 1024));
    for_each_point(argument, progress, "triangles within", [&](const Vec3& p) {
        Neighbourhood found = collect_triangles(index, p, radius, buffer);
        if (!found.complete) {
            buffer.resize(index.triangle_count());
            found = collect_triangles(index, p, radius, buffer);
        }
        triangles.insert(triangles.end(), buffer.begin(),
                         buffer.begin() + static_cast<std::ptrdiff_t>(found.written));
        first.push_back(triangles.size());
    });
    return result_type("Neighbours")(
        array_of<std::int64_t>(std::span<const std::size_t>(first)),
        array_of<std::int32_t>(std::span<const TriangleId>(triangles)));
}

py::object nearest(const MeshIndex& index, const py::object& points, Integer count, double radius,
                   const py::object& progress)
{
    const PointsArgument argument(points, "points");
    constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
    const std::size_t columns = count_of(count, "count", most, 1);
    check_not_negative(radius, "radius");
    // At most 2^63, so that nothing wraps.
    const std::size_t row_bytes = columns * (sizeof(double) + sizeof(std::int32_t));
    const auto most_rows = std::numeric_limits<std::int64_t>::max() / row_bytes;
    value_of(check_budget({}, std::min(argument.size(), most_rows) * row_bytes, "the answer",
                          "ask for fewer triangles or fewer points at once"));
    auto distances = new_rows<double>(argument.size(), columns);
    auto triangles = new_rows<std::int32_t>(argument.size(), columns);
    double* distance = distances.mutable_data();
    std::int32_t* triangle = triangles.mutable_data();
    std::vector<NearTriangle> buffer(std::min<std::size_t>(columns, index.triangle_count()));
    for_each_point(argument, progress, "nearest triangles", [&](const Vec3& p) {
        const std::size_t found = collect_nearest(index, p, buffer, radius).written;
        for (std::size_t k = 0; k < columns; ++k) {
            const NearTriangle one = k < found ? buffer[k] : NearTriangle{};
            *distance++ = std::sqrt(one.squared_distance);
            *triangle++ = k < found ? static_cast<std::int32_t>(to_index(one.triangle)) : -1;
        }
    });
    return result_type("Nearest")(distances, triangles);
}

py::array in_box(const MeshIndex& index, const py::object& lower, const py::object& upper)
{
    const Box box = box_between(lower, upper);
    std::vector<TriangleId> triangles(index.triangle_count());
    triangles.resize(collect_triangles(index, box, triangles).written);
    return array_of<std::int32_t>(std::span<const TriangleId>(triangles));
}

} // namespace

void bind_near(py::class_<MeshIndex>& index)
{
    index
        .def("within", &within, py::arg("points"), py::arg("radius"), py::kw_only(),
             py::arg("progress") = py::none(),
             "The triangles within a radius of points (n, 3), in the mesh's unit, as Neighbours.")
        .def("nearest", &nearest, py::arg("points"), py::arg("count"), py::kw_only(),
             py::arg("radius") = infinity, py::arg("progress") = py::none(),
             R"(The `count` triangles nearest to points (n, 3), as Nearest.

By squared distance, equal ones by id. Where fewer are within the radius, the rest of the row is inf and -1.)")
        .def("in_box", &in_box, py::arg("lower"), py::arg("upper"),
             "The triangles that have a point in common with a box, of corners (3,): (m,) int32, "
             "ascending. Exact.");
}

} // namespace proxima::python
