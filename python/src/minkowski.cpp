#include "arrays.h"
#include "bindings.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/minkowski_sum.h"
#include "run.h"
#include "unlocked.h"

#include <pybind11/operators.h>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

ConvexPolyhedron hull_of(const py::object& points, const py::object& progress)
{
    const PointsArgument argument(points, "points");
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return convex_hull(argument.points(), {}, {.progress = watched});
    });
}

/// Loops of vertices, one after the other.
template <class Body>
py::object facets_of(const Body& body)
{
    std::vector<std::size_t> first{0};
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t facet = 0; facet < body.facet_count(); ++facet) {
        const auto loop = body.facet_loop(facet);
        vertices.insert(vertices.end(), loop.begin(), loop.end());
        first.push_back(vertices.size());
    }
    return result_type("Facets")(array_of<std::int64_t>(std::span<const std::size_t>(first)),
                                 array_of<std::int32_t>(std::span<const std::uint32_t>(vertices)));
}

/// (n, 4): normal and offset.
template <class Body>
py::array half_spaces_of(const Body& body)
{
    auto array = new_rows<double>(body.facet_count(), 4);
    double* to = array.mutable_data();
    for (std::uint32_t facet = 0; facet < body.facet_count(); ++facet) {
        const HalfSpace half_space = body.half_space(facet);
        for (int k = 0; k < 3; ++k) *to++ = half_space.normal[k];
        *to++ = half_space.offset;
    }
    return array;
}

py::array vertices_of_polyhedron(const ConvexPolyhedron& polyhedron)
{
    return rows_of(polyhedron.points());
}

py::array vertices_of_sum(const MinkowskiSum& sum)
{
    auto array = new_rows<double>(sum.point_count(), 3);
    const auto positions = elements_of<Vec3>(array);
    for (std::uint32_t vertex = 0; vertex < positions.size(); ++vertex)
        positions[vertex] = sum.position(vertex);
    return array;
}

void check_finite(const PointsArgument& points)
{
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!points.points()[i].allFinite())
            refuse("points", "point " + std::to_string(i) + " is not finite: leave it out");
    }
}

py::array contains_points(const MinkowskiSum& sum, const py::object& points)
{
    const PointsArgument argument(points, "points");
    check_finite(argument);
    auto answers = new_array<bool>(argument.size());
    const auto to = elements_of<bool>(answers);
    {
        const Unlocked unlocked;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = contains(sum, argument.points()[i]);
    }
    return answers;
}

py::object distances_of(const MinkowskiSum& sum, const py::object& points)
{
    const PointsArgument argument(points, "points");
    check_finite(argument);
    auto distance = new_array<double>(argument.size());
    auto nearest = new_rows<double>(argument.size(), 3);
    auto direction = new_rows<double>(argument.size(), 3);
    auto facet = new_array<std::int32_t>(argument.size());
    const auto nearest_to = elements_of<Vec3>(nearest);
    const auto direction_to = elements_of<Vec3>(direction);
    double* const distance_to = distance.mutable_data();
    std::int32_t* const facet_to = facet.mutable_data();
    {
        const Unlocked unlocked;
        for (std::size_t i = 0; i < argument.size(); ++i) {
            const SurfacePoint found = signed_distance(sum, argument.points()[i]);
            distance_to[i] = found.distance;
            nearest_to[i] = found.nearest;
            direction_to[i] = found.direction;
            facet_to[i] = static_cast<std::int32_t>(found.facet);
        }
    }
    return result_type("SumDistances")(distance, nearest, direction, facet);
}

template <class Body>
std::string represent_body(const char* name, const Body& body, std::size_t points)
{
    return std::string("<proxima.") + name + ": " + std::to_string(points) + " vertices, " +
           std::to_string(body.facet_count()) + " facets>";
}

} // namespace

void bind_minkowski(py::module_& module)
{
    py::class_<ConvexPolyhedron>(module, "Polyhedron",
                                 R"(A bounded convex polyhedron: the hull of points. Immutable.

Polyhedron(points, *, progress=None)

    points  (n, 3) floats. Those that are no corners are left out, the others keep their order

Exact for the doubles given: facets may have any number of corners and no two lie in one plane. It may be flat. Raises
InvalidInput without points or with NaN.)")
        .def(py::init(&hull_of), py::arg("points"), py::kw_only(), py::arg("progress") = py::none())
        .def_static(
            "of_mesh",
            [](const TriangleMesh& mesh) {
                return run(py::none(), Duration::lengthy, [&](Progress* watched) {
                    return polyhedron_of_mesh(mesh, {.execution = {.progress = watched}});
                });
            },
            py::arg("mesh"),
            "The polyhedron that a closed convex mesh bounds; InvalidInput for others.")
        .def_static(
            "box",
            [](const py::object& lower, const py::object& upper) {
                return value_of(polyhedron_of_box(box_between(lower, upper)));
            },
            py::arg("lower"), py::arg("upper"),
            "An axis-aligned box between two corners, (3,) each.")
        .def(
            "mirrored", [](const ConvexPolyhedron& self) { return mirrored(self); },
            "-x for all x of the polyhedron.")
        .def_property_readonly("vertices", &vertices_of_polyhedron, "(n, 3) float64.")
        .def_property_readonly("facets", &facets_of<ConvexPolyhedron>,
                               "Facets: loops of vertices, counter-clockwise seen from outside.")
        .def_property_readonly("half_spaces", &half_spaces_of<ConvexPolyhedron>,
                               "(f, 4) float64 n, d: inside is n . x <= d, n of length 1.")
        .def_property_readonly("dimension", &ConvexPolyhedron::dimension,
                               "0 a point, 1 a segment, 2 a polygon, 3 a body.")
        .def("__repr__",
             [](const ConvexPolyhedron& self) {
                 return represent_body("Polyhedron", self, self.points().size());
             })
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def("__reduce__", [](const py::object& self) {
            return py::make_tuple(self.attr("__class__"), py::make_tuple(self.attr("vertices")));
        });

    py::class_<MinkowskiSum>(
        module, "MinkowskiSum",
        R"(The Minkowski sum of two convex polyhedra, made by minkowski_sum(). Immutable.

Of A and the mirrored B it answers for the pair: B moved by t overlaps A exactly if t is in it.)")
        .def_property_readonly("vertices", &vertices_of_sum, "(n, 3) float64.")
        .def_property_readonly("facets", &facets_of<MinkowskiSum>,
                               "Facets: loops of vertices, counter-clockwise seen from outside.")
        .def_property_readonly("half_spaces", &half_spaces_of<MinkowskiSum>,
                               "(f, 4) float64 n, d: inside is n . x <= d, n of length 1.")
        .def_property_readonly("dimension", &MinkowskiSum::dimension,
                               "0 a point, 1 a segment, 2 a polygon, 3 a body.")
        .def("contains", &contains_points, py::arg("points"),
             "Whether points (n, 3) are in the closed sum, exactly: (n,) bool.")
        .def("signed_distance", &distances_of, py::arg("points"),
             "How far points (n, 3) are from the sum's surface, negative inside, as SumDistances.")
        .def("__repr__", [](const MinkowskiSum& self) {
            return represent_body("MinkowskiSum", self, self.point_count());
        });

    module.def(
        "minkowski_sum",
        [](const ConvexPolyhedron& a, const ConvexPolyhedron& b, const py::object& progress) {
            return run(progress, Duration::lengthy, [&](Progress* watched) {
                return minkowski_sum(a, b, {.execution = {.progress = watched}});
            });
        },
        py::arg("a"), py::arg("b"), py::kw_only(), py::arg("progress") = py::none(),
        "The sum of two polyhedra: all a + b.");
    module.def(
        "separation",
        [](const ConvexPolyhedron& a, const ConvexPolyhedron& b) {
            const Separation found = run(py::none(), Duration::lengthy, [&](Progress* watched) {
                return separation(a, b, {.execution = {.progress = watched}});
            });
            auto direction = new_array<double>(3);
            elements_of<Vec3>(direction)[0] = found.direction;
            return py::make_tuple(found.distance, direction);
        },
        py::arg("a"), py::arg("b"),
        R"(Distance of two polyhedra, negative where they overlap (the depth of penetration), and the direction from a to b
of length 1: moving b by -distance along it lets them just touch.)");
}

} // namespace proxima::python
