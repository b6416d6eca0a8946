#include "arrays.h"
#include "bindings.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"
#include "proxima/triangle_mesh.h"
#include "run.h"

#include <filesystem>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <span>
#include <string>

namespace proxima::python {

namespace {

TriangleMesh make_mesh(const py::object& vertices, const py::object& faces)
{
    const PointsArgument positions(vertices, "vertices");
    const auto points = positions.points();
    return value_of(make_triangle_mesh({points.begin(), points.end()}, corners_of(faces, "faces")));
}

TriangleMesh of_points(const py::object& points)
{
    const PointsArgument positions(points, "points");
    return value_of(mesh_of_points({positions.points().begin(), positions.points().end()}));
}

TriangleMesh of_segments(const py::object& points, const py::object& segments)
{
    const PointsArgument positions(points, "points");
    return value_of(mesh_of_segments({positions.points().begin(), positions.points().end()},
                                     segments_of(segments, "segments")));
}

ReadOptions read_options(std::optional<bool> weld, bool points_and_lines, Progress* progress)
{
    return {.weld = !weld   ? Weld::by_format
                    : *weld ? Weld::exact_positions
                            : Weld::never,
            .primitives = points_and_lines ? Primitives::points_and_lines : Primitives::triangles,
            .execution = {.progress = progress}};
}

TriangleMesh read(const std::filesystem::path& path, std::optional<bool> weld,
                  bool points_and_lines, const py::object& progress)
{
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return read_mesh(path, read_options(weld, points_and_lines, watched));
    });
}

TriangleMesh from_bytes(const py::buffer& data, const std::string& format, std::optional<bool> weld,
                        bool points_and_lines, const py::object& progress)
{
    const auto known = format_of_path("data." + format);
    if (!known) {
        refuse("format", "must be one of " + known_mesh_extensions() + " without the dot, is \"" +
                             format + "\"");
    }
    const py::buffer_info memory = data.request();
    const auto size = static_cast<std::size_t>(memory.size * memory.itemsize);
    if (!PyBuffer_IsContiguous(memory.view(), 'C')) refuse("data", "must be contiguous");
    const std::span bytes(static_cast<const std::byte*>(memory.ptr), size);
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return read_mesh_from_memory(bytes, *known, read_options(weld, points_and_lines, watched));
    });
}

void write(const TriangleMesh& mesh, const std::filesystem::path& path, bool ascii,
           const py::object& progress)
{
    run(progress, Duration::lengthy, [&](Progress* watched) {
        return write_mesh(mesh, path,
                          {.ply = ascii ? PlyEncoding::ascii : PlyEncoding::binary,
                           .stl = ascii ? StlEncoding::ascii : StlEncoding::binary,
                           .execution = {.progress = watched}});
    });
}

TriangleMesh make_sample(const std::string& name)
{
    return run(py::none(), Duration::lengthy, [&](Progress* watched) {
        return sample_mesh(name, {.execution = {.progress = watched}});
    });
}

py::array vertices_of_mesh(const py::object& self)
{
    const auto positions = self.cast<const TriangleMesh&>().positions();
    return view_of(py::array_t<double>(
        std::vector{static_cast<py::ssize_t>(positions.size()), py::ssize_t{3}},
        static_cast<const double*>(static_cast<const void*>(positions.data())), self));
}

py::array faces_of(const py::object& self)
{
    const auto triangles = self.cast<const TriangleMesh&>().triangles();
    return view_of(py::array_t<std::uint32_t>(
        std::vector{static_cast<py::ssize_t>(triangles.size()), py::ssize_t{3}},
        static_cast<const std::uint32_t*>(static_cast<const void*>(triangles.data())), self));
}

py::array bounds_of_mesh(const TriangleMesh& mesh)
{
    const Box box = value_of(checked_bounding_box(mesh));
    auto bounds = new_rows<double>(2, 3);
    elements_of<Vec3>(bounds)[0] = box.lower;
    elements_of<Vec3>(bounds)[1] = box.upper;
    return bounds;
}

std::string represent_mesh(const TriangleMesh& mesh)
{
    return "<proxima.Mesh: " + std::to_string(mesh.vertex_count()) + " vertices, " +
           std::to_string(mesh.triangle_count()) + " triangles>";
}

} // namespace

void bind_mesh(py::module_& module)
{
    py::class_<TriangleMesh> mesh(module, "Mesh",
                                  R"(A triangle mesh. Immutable; any number of threads may use it.

Mesh(vertices, faces)

    vertices  (V, 3) floats, in any unit: all lengths are in that unit
    faces     (F, 3) integers, indices into vertices, counter-clockwise seen from outside

float32 or float64, any memory order; both arrays are copied. Raises InvalidInput where an index is out of
range. NaN and infinite coordinates are refused when an Index or an Octree is built.)");
    mesh.def(py::init(&make_mesh), py::arg("vertices"), py::arg("faces"))
        .def_static("of_points", &of_points, py::arg("points"),
                    R"(A point cloud, (V, 3) floats, as a mesh: triangle i is (i, i, i).

Every query takes such meshes. The closest feature is always a vertex; they have no inside, and rays hit them only where they
meet a point exactly.)")
        .def_static(
            "of_segments", &of_segments, py::arg("points"), py::arg("segments"),
            R"(Segments, such as those of polylines, as a mesh: triangle i is (v, w, w) of segment (v, w).

    points    (V, 3) floats
    segments  (S, 2) integers, indices into points)")
        .def_static("read", &read, py::arg("path"), py::kw_only(), py::arg("weld") = py::none(),
                    py::arg("points_and_lines") = false, py::arg("progress") = py::none(),
                    R"(Reads OBJ, PLY, STL, OFF or XYZ in float64; 3DS, glTF and GLB by assimp.

Polygons become triangles; vertices and faces keep the order of the file.

    weld              True: vertices at one position become one; False: never; None: for STL and 3DS, whose vertices repeat
    points_and_lines  read points (v, v, v) and segments (v, w, w) of OBJ, PLY and OFF, too; XYZ has points only

Raises FileMissing, or InvalidInput with file and line.)")
        .def_static("from_bytes", &from_bytes, py::arg("data"), py::arg("format"), py::kw_only(),
                    py::arg("weld") = py::none(), py::arg("points_and_lines") = false,
                    py::arg("progress") = py::none(),
                    R"(Reads a file that is in memory: bytes, a memoryview, an array of uint8.

    format                  "obj", "ply", "stl", "off", "xyz", "3ds", "gltf" or "glb"
    weld, points_and_lines  as in read()

Raises InvalidInput with the line or byte. A glTF that refers to other files is refused.)")
        .def("write", &write, py::arg("path"), py::kw_only(), py::arg("ascii") = false,
             py::arg("progress") = py::none(),
             R"(Writes OBJ, PLY, STL or OFF, told by the extension: whole or not at all.

Positions read back to the same bits, except through binary STL, which is float32. PLY and STL are binary unless
ascii=True.)")
        .def_static(
            "sample", &make_sample, py::arg("name"),
            R"(A built-in mesh: "cube", "octahedron", "sphere:STACKSxSLICES", "icosphere:N", "torus:NxM",
"spaceship:TRIANGLES".)")
        .def_property_readonly("vertices", &vertices_of_mesh,
                               "(V, 3) float64, read-only, the mesh's own memory.")
        .def_property_readonly("faces", &faces_of,
                               "(F, 3) uint32, read-only, the mesh's own memory.")
        .def_property_readonly(
            "bounds", &bounds_of_mesh,
            "(2, 3) float64: lowest and highest corner of the box of all triangles.")
        .def_property_readonly("fingerprint", &mesh_fingerprint,
                               "int: the same for the same positions and triangles in the same "
                               "order. See Index.fingerprint.")
        .def("__repr__", &represent_mesh)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def("__reduce__", [](const py::object& self) {
            return py::make_tuple(self.attr("__class__"),
                                  py::make_tuple(vertices_of_mesh(self), faces_of(self)));
        });
    bind_mesh_repair(mesh);
}

} // namespace proxima::python
