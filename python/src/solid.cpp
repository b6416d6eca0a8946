#include "arrays.h"
#include "contour.h"
#include "index_methods.h"
#include "proxima/contacts.h"
#include "run.h"

#include <cstdint>
#include <string>

namespace proxima::python {

namespace {

Solid solid_of_model(const py::object& model, Integer threads, const py::object& progress)
{
    const Threads thread_count = threads_of(threads);
    const MeshIndex index = index_of(model, "a proxima.Mesh or Index");
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return build_solid(index, {{.threads = thread_count, .progress = watched}});
    });
}

py::object overlaps(const Solid& self, const Solid& other, const py::object& poses)
{
    const Poses moved = poses_of(poses);
    auto answers = new_array<bool>(moved.poses.size());
    bool* const to = answers.mutable_data();
    run(py::none(), Duration::lengthy, [&](Progress* watched) -> Status {
        for (std::size_t i = 0; i < moved.poses.size(); ++i) {
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the tests were cancelled");
            to[i] = solids_overlap(self, other, moved.poses[i]);
        }
        return {};
    });
    if (moved.single) return py::bool_(to[0]);
    return answers;
}

py::object depth_of(const Solid& self, const Solid& other, const py::object& pose,
                    Integer max_points, Integer max_directions, const py::object& progress)
{
    const RigidTransform moved = pose_of(pose);
    const auto limit = [](Integer count, const char* name) {
        return static_cast<std::uint32_t>(count_of(count, name, max_penetration_search));
    };
    PenetrationOptions options{.max_points = limit(max_points, "max_points"),
                               .max_directions = limit(max_directions, "max_directions")};
    const PenetrationDepth found = run(progress, Duration::lengthy, [&](Progress* watched) {
        options.execution.progress = watched;
        return penetration_depth(self, other, moved, options);
    });
    return result_type("PenetrationDepth")(found.lower, found.upper, vector_of(found.direction),
                                           vector_of(found.translation), vector_of(found.deepest),
                                           static_cast<int>(found.method));
}

/// The columns of regions, of their points and of their lines.
py::object columns_of(const ContactRegions& found)
{
    const std::size_t count = found.regions.size();
    std::size_t point_count = 0;
    for (const ContactRegion& region : found.regions) point_count += region.point_count;
    auto position = new_rows<double>(count, 3);
    auto normal = new_rows<double>(count, 3);
    auto depth = new_array<double>(count);
    auto length = new_array<double>(count);
    auto area = new_array<double>(count);
    auto first = new_array<std::int64_t>(count + 1);
    auto on_a = new_rows<double>(point_count, 3);
    auto on_b = new_rows<double>(point_count, 3);
    auto point_depth = new_array<double>(point_count);
    auto first_line = new_array<std::int64_t>(count + 1);
    std::size_t row = 0;
    first.mutable_data()[0] = first_line.mutable_data()[0] = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const ContactRegion& region = found.regions[i];
        elements_of<Vec3>(position)[i] = region.position;
        elements_of<Vec3>(normal)[i] = region.normal;
        depth.mutable_data()[i] = region.depth;
        length.mutable_data()[i] = region.length;
        area.mutable_data()[i] = region.area;
        for (const RegionPoint& point : region.contacts()) {
            elements_of<Vec3>(on_a)[row] = point.on_a;
            elements_of<Vec3>(on_b)[row] = point.on_b;
            point_depth.mutable_data()[row++] = point.depth;
        }
        first.mutable_data()[i + 1] = static_cast<std::int64_t>(row);
        first_line.mutable_data()[i + 1] =
            static_cast<std::int64_t>(region.first_line + region.line_count);
    }
    return result_type("ContactRegions")(
        position, normal, depth, length, area, first, on_a, on_b, point_depth, first_line,
        array_of<std::int64_t>(std::span<const std::size_t>(found.lines)),
        contour_columns(found.contour));
}

py::object regions_of(const Solid& self, const Solid& other, const py::object& pose,
                      const py::object& progress)
{
    const RigidTransform moved = pose_of(pose);
    return columns_of(run(progress, Duration::lengthy, [&](Progress* watched) {
        return contact_regions(self, other, moved, {{.progress = watched}});
    }));
}

std::string represent_solid(const Solid& self)
{
    return "<proxima.Solid: " + std::to_string(self.index().triangle_count()) + " triangles, " +
           (self.is_convex() ? "convex>" : "not convex>");
}

} // namespace

void bind_solid(py::module_& module)
{
    py::class_<Solid>(module, "Solid",
                      R"(A closed mesh with its inside: whether two overlap, how deep, and where.

Solid(model, *, threads=0, progress=None)

    model  a Mesh, or an Index, which the Solid keeps

Immutable; any number of threads may use it. What touches, overlaps. 5 to 15 us of work per triangle. Raises InvalidInput for
a mesh that is open, not consistently oriented or flat, and for a part that is turned inside out: a cavity may be, where it
lies within another part and touches none.)")
        .def(py::init(&solid_of_model), py::arg("model"), py::kw_only(), py::arg("threads") = 0,
             py::arg("progress") = py::none())
        .def(
            "overlaps", &overlaps, py::arg("other"), py::arg("poses") = py::none(),
            R"(Whether this solid and another one, moved by poses as in Index.intersect(), have a point in common. Exact.

A bool, or (n,) bool for several poses.)")
        .def(
            "penetration_depth", &depth_of, py::arg("other"), py::arg("pose") = py::none(),
            py::kw_only(), py::arg("max_points") = PenetrationOptions{}.max_points,
            py::arg("max_directions") = PenetrationOptions{}.max_directions,
            py::arg("progress") = py::none(),
            R"(How far the other solid, moved by a pose (3, 4) or (4, 4), must move to be free, as a PenetrationDepth.

    max_points      at which distances to both surfaces are taken, for the lower bound
    max_directions  that are tried besides those of hull, axes and surfaces, for the upper bound

An interval that holds the depth: as wide as roundings for two convex meshes, perhaps wide for others, which take 10 to 400 ms
for thousands of triangles.)")
        .def(
            "contact_regions", &regions_of, py::arg("other"), py::arg("pose") = py::none(),
            py::kw_only(), py::arg("progress") = py::none(),
            R"(Where the surfaces of two solids meet, the other one moved by a pose (3, 4) or (4, 4), as ContactRegions.

None where one is inside the other. 4 us per pair of triangles that meet, and 0.3 to 30 ms per region.)")
        .def_property_readonly("index", &Solid::index, py::return_value_policy::copy,
                               "Index: of the mesh, with signs.")
        .def_property_readonly("is_convex", &Solid::is_convex,
                               "bool: whether the mesh is its convex hull, up to hull_error.")
        .def_property_readonly("hull_error", &Solid::hull_error,
                               "float: how far a convex mesh's hull is from the solid at most, in "
                               "the mesh's unit.")
        .def("__repr__", &represent_solid)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def("__reduce__", [](const py::object& self) {
            return py::make_tuple(self.attr("__class__"), py::make_tuple(self.attr("index")));
        });
}

} // namespace proxima::python
