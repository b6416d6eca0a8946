#include "arrays.h"
#include "index_methods.h"
#include "proxima/cull.h"
#include "proxima/view_volume.h"
#include "unlocked.h"

#include <vector>

namespace proxima::python {

namespace {

py::array planes_of(const ViewVolume& volume)
{
    auto array = new_rows<double>(volume.planes().size(), 4);
    double* to = array.mutable_data();
    for (const ViewPlane& plane : volume.planes()) {
        for (int k = 0; k < 3; ++k) *to++ = plane.normal[k];
        *to++ = plane.offset;
    }
    return array;
}

py::array visible_triangles(const MeshIndex& index, const py::object& planes, bool exact)
{
    const ViewVolume volume = volume_of(planes);
    std::vector<TriangleId> ids;
    {
        const Unlocked unlocked;
        visible_triangles(index, volume, exact ? CullMode::exact : CullMode::conservative, ids);
    }
    return array_of<std::int32_t>(std::span<const TriangleId>(ids));
}

} // namespace

ViewVolume volume_of(const py::object& planes)
{
    const py::array_t<double> array = doubles_of(planes, "planes");
    if (array.ndim() != 2 || array.shape(1) != 4)
        refuse("planes", "must have shape (n, 4): normal and offset of each");
    std::vector<ViewPlane> list;
    for (py::ssize_t i = 0; i < array.shape(0); ++i) {
        const double* const plane = array.data() + 4 * i;
        list.push_back({Vec3(plane), plane[3]});
    }
    return value_of(make_view_volume(list));
}

void bind_views(py::module_& module, py::class_<MeshIndex>& index)
{
    index.def(
        "visible", &visible_triangles, py::arg("planes"), py::kw_only(), py::arg("exact") = false,
        R"(Ids of the triangles in a view volume, (m,) int32, ascending. Occlusion is not tested.

    planes  (k, 4) floats a, b, c, d: inside is where a x + b y + c z + d >= 0 for all; see perspective() and
            orthographic()
    exact   True: exactly those that have a point in common with the volume, else also some near its edges)");

    module.def(
        "perspective",
        [](const py::object& eye, const py::object& forward, const py::object& up,
           double field_of_view, double aspect, double near, double far) {
            return planes_of(value_of(
                make_perspective_volume({point_of(eye, "eye"), point_of(forward, "forward"),
                                         point_of(up, "up"), field_of_view, aspect, near, far})));
        },
        py::arg("eye"), py::arg("forward"), py::arg("up") = py::make_tuple(0.0, 1.0, 0.0),
        py::kw_only(), py::arg("field_of_view") = PerspectiveCamera{}.field_of_view,
        py::arg("aspect") = 1.0, py::arg("near") = PerspectiveCamera{}.near,
        py::arg("far") = infinity,
        R"(The planes of what a camera sees, for Index.visible: (6, 4) float64, (5, 4) where far is infinite.

eye, forward, up are (3,), directions of any length; field_of_view in radians from bottom to top; aspect is width over
height; near and far lengths along forward.)");
    module.def(
        "orthographic",
        [](const py::object& eye, const py::object& forward, const py::object& up, double width,
           double height, double near, double far) {
            return planes_of(value_of(
                make_orthographic_volume({point_of(eye, "eye"), point_of(forward, "forward"),
                                          point_of(up, "up"), width, height, near, far})));
        },
        py::arg("eye"), py::arg("forward"), py::arg("up") = py::make_tuple(0.0, 1.0, 0.0),
        py::kw_only(), py::arg("width") = 2.0, py::arg("height") = 2.0, py::arg("near") = 0.0,
        py::arg("far") = infinity,
        "The planes of a box along `forward`, for Index.visible: as perspective().");
}

} // namespace proxima::python
