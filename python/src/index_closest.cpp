#include "arrays.h"
#include "index_methods.h"
#include "proxima/closest_feature.h"
#include "proxima/signed_distance.h"
#include "run.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// The names of Closest's columns, in its order.
constexpr std::array<const char*, 6> closest_columns{"distance",     "point",   "triangle",
                                                     "feature_kind", "feature", "barycentric"};

/// Arrays that a batch writes to; None where a column is not wanted.
struct ClosestArrays {
    py::object distance = py::none();
    py::object point = py::none();
    py::object triangle = py::none();
    py::object feature_kind = py::none();
    py::object feature = py::none();
    py::object barycentric = py::none();

    [[nodiscard]] std::array<py::object*, 6> all()
    {
        return {&distance, &point, &triangle, &feature_kind, &feature, &barycentric};
    }
};

template <class T>
void check_output(const py::object& object, const char* name, std::size_t rows, std::size_t columns)
{
    if (object.is_none()) return;
    const bool fits = py::isinstance<py::array_t<T, py::array::c_style>>(object) && [&] {
        const auto array = py::reinterpret_borrow<py::array>(object);
        const auto ndim = columns == 1 ? 1 : 2;
        return array.writeable() && array.ndim() == ndim &&
               array.shape(0) == static_cast<py::ssize_t>(rows) &&
               (ndim == 1 || array.shape(1) == static_cast<py::ssize_t>(columns));
    }();
    if (!fits) {
        refuse(std::string("out.") + name,
               "must be an earlier answer for as many points, whose arrays can be written to");
    }
}

std::vector<std::string> column_names(const py::object& columns)
{
    const char* const wanted = R"(a tuple of names, such as ("distance", "triangle"))";
    if (py::isinstance<py::str>(columns) || !py::isinstance<py::sequence>(columns))
        refuse_object(columns, "columns", wanted);
    std::vector<std::string> names;
    for (const py::handle& name : py::reinterpret_borrow<py::sequence>(columns)) {
        if (!py::isinstance<py::str>(name)) {
            refuse_object(name, ("columns[" + std::to_string(names.size()) + "]").c_str(),
                          "the name of a column");
        }
        names.push_back(text_of(name));
    }
    return names;
}

ClosestArrays closest_arrays(std::size_t size, const py::object& columns, const py::object& out)
{
    ClosestArrays arrays;
    if (!out.is_none()) {
        if (!py::isinstance(out, result_type("Closest")))
            refuse_object(out, "out", "a proxima.Closest");
        if (!columns.is_none()) refuse("columns", "are those of out: leave them out");
        const auto all = arrays.all();
        for (std::size_t i = 0; i < all.size(); ++i) *all[i] = out.attr(closest_columns[i]);
        check_output<double>(arrays.distance, "distance", size, 1);
        check_output<double>(arrays.point, "point", size, 3);
        check_output<std::int32_t>(arrays.triangle, "triangle", size, 1);
        check_output<std::uint8_t>(arrays.feature_kind, "feature_kind", size, 1);
        check_output<std::int32_t>(arrays.feature, "feature", size, 1);
        check_output<double>(arrays.barycentric, "barycentric", size, 3);
        return arrays;
    }
    std::vector<std::string> wanted(closest_columns.begin(), closest_columns.end());
    if (!columns.is_none()) wanted = column_names(columns);
    for (const std::string& name : wanted) {
        if (name == "distance") {
            arrays.distance = new_array<double>(size);
        } else if (name == "point") {
            arrays.point = new_rows<double>(size, 3);
        } else if (name == "triangle") {
            arrays.triangle = new_array<std::int32_t>(size);
        } else if (name == "feature_kind") {
            arrays.feature_kind = new_array<std::uint8_t>(size);
        } else if (name == "feature") {
            arrays.feature = new_array<std::int32_t>(size);
        } else if (name == "barycentric") {
            arrays.barycentric = new_rows<double>(size, 3);
        } else {
            refuse("columns", "has no column \"" + name + "\"");
        }
    }
    return arrays;
}

template <class As, class T>
std::span<As> elements_of_any(const py::object& object)
{
    if (object.is_none()) return {};
    auto array = py::reinterpret_borrow<py::array_t<T>>(object);
    return elements_of<As>(array);
}

/// Whether writing to an array may change points that are still to be read.
bool shares_memory(const py::object& array, std::span<const Vec3> points)
{
    if (array.is_none()) return false;
    const auto given = py::reinterpret_borrow<py::array>(array);
    const auto* const begin = static_cast<const std::byte*>(given.data());
    const auto bytes = std::as_bytes(points);
    return begin < bytes.data() + bytes.size() && bytes.data() < begin + given.nbytes();
}

py::object closest(const MeshIndex& index, const py::object& points, const py::object& columns,
                   const py::object& out, Integer threads, const py::object& progress)
{
    PointsArgument argument(points, "points");
    ClosestArrays arrays = closest_arrays(argument.size(), columns, out);
    const auto shares = [&](const py::object* array) {
        return shares_memory(*array, argument.points());
    };
    if (!out.is_none() && std::ranges::any_of(arrays.all(), shares))
        argument = PointsArgument(py::module_::import("numpy").attr("array")(points), "points");
    const ClosestOutputs outputs{
        .triangles = elements_of_any<TriangleId, std::int32_t>(arrays.triangle),
        .distances = elements_of_any<double, double>(arrays.distance),
        .points = elements_of_any<Vec3, double>(arrays.point),
        .feature_kinds = elements_of_any<FeatureKind, std::uint8_t>(arrays.feature_kind),
        .feature_ids = elements_of_any<std::uint32_t, std::int32_t>(arrays.feature),
        .barycentrics = elements_of_any<std::array<double, 3>, double>(arrays.barycentric)};
    const Threads thread_count = threads_of(threads);
    run(progress, duration_of(argument.size()), [&](Progress* watched) {
        return closest_features(index, argument.points(), outputs,
                                {.execution = {.threads = thread_count, .progress = watched}});
    });
    if (!out.is_none()) return out;
    return result_type("Closest")(arrays.distance, arrays.point, arrays.triangle,
                                  arrays.feature_kind, arrays.feature, arrays.barycentric);
}

py::object signed_distance_of(const MeshIndex& index, const py::object& points, bool method,
                              Integer threads, const py::object& progress)
{
    if (!index.has_signs())
        refuse("index", "has no signs: build it with signs=True, or call with_signs()");
    const PointsArgument argument(points, "points");
    auto distances = new_array<double>(argument.size());
    auto methods = new_array<std::uint8_t>(method ? argument.size() : 0);
    const SignedOutputs outputs{.distances = elements_of<double>(distances),
                                .methods = elements_of<SignMethod>(methods)};
    const Threads thread_count = threads_of(threads);
    run(progress, duration_of(argument.size()), [&](Progress* watched) {
        return signed_distances(index, argument.points(), outputs,
                                {.execution = {.threads = thread_count, .progress = watched}});
    });
    if (method) return py::make_tuple(distances, methods);
    return distances;
}

} // namespace

void bind_closest(py::class_<MeshIndex>& index)
{
    index
        .def("closest", &closest, py::arg("points"), py::kw_only(), py::arg("columns") = py::none(),
             py::arg("out") = py::none(), py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(The closest points of the mesh, as Closest: arrays by column.

    points   (n, 3) floats. float64 in C order is used in place; all else is copied once
    columns  names of the columns to compute, the others are None. ("distance", "triangle") is quickest
    out      an earlier Closest for n points: its arrays are written again and it is returned

Raises InvalidInput where a point is not finite. 0.5 to 5 us a point on one thread.)")
        .def(
            "signed_distance", &signed_distance_of, py::arg("points"), py::kw_only(),
            py::arg("method") = false, py::arg("threads") = 0, py::arg("progress") = py::none(),
            R"(Signed distances of points (n, 3) from the mesh: (n,) float64, negative inside, in the mesh's unit.

With method=True a pair: distances, and (n,) uint8 that say how each sign was found, see SIGN_METHODS. Inside is where
the winding number is at least 1/2, so that meshes with holes have an inside too. Needs signs.)");
}

} // namespace proxima::python
