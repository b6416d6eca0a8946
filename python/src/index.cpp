#include "arrays.h"
#include "bindings.h"
#include "index_methods.h"
#include "mesh_topology.h"
#include "pickled.h"
#include "proxima/index_io.h"
#include "proxima/mesh_index.h"
#include "run.h"

#include <filesystem>
#include <optional>
#include <pybind11/stl/filesystem.h>
#include <string>

namespace proxima::python {

namespace {

/// False, True, or bytes. Nothing where there are to be no lists.
std::optional<ListOptions> list_options_of(const py::object& lists)
{
    if (lists.is_none() || lists.ptr() == Py_False) return std::nullopt;
    if (lists.ptr() == Py_True) return ListOptions{};
    if (!py::isinstance<py::int_>(lists))
        refuse("lists", "must be False, True or a number of bytes");
    return ListOptions{.list_bytes = count_of(lists.cast<Integer>(), "lists", any_count, 1)};
}

MeshIndex index_of_mesh(const TriangleMesh& mesh, const py::object& lists, bool distances,
                        bool signs, Integer threads, const py::object& progress)
{
    const auto list_options = list_options_of(lists);
    const Threads thread_count = threads_of(threads);
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        const Execution execution{.threads = thread_count, .progress = watched};
        auto index = build_mesh_index(mesh, {.execution = execution});
        if (index && list_options) {
            ListOptions options = *list_options;
            options.execution = execution;
            index = with_lists(*index, options);
        }
        if (index && distances) index = with_slabs(*index, {.execution = execution});
        if (index && signs) index = with_signs(*index, {.execution = execution});
        return index;
    });
}

void save_index(const MeshIndex& index, const std::filesystem::path& path,
                const py::object& progress)
{
    run(progress, Duration::lengthy, [&](Progress* watched) {
        return save_index(index, path, {.execution = {.progress = watched}});
    });
}

MeshIndex load(const std::filesystem::path& path, bool map, const py::object& progress)
{
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return load_index(path, {.access = map ? FileAccess::map : FileAccess::read,
                                 .execution = {.progress = watched}});
    });
}

MeshIndex refit(const MeshIndex& self, const py::object& vertices, const py::object& given,
                Integer threads, const py::object& progress)
{
    const PointsArgument positions(vertices, "vertices");
    if (positions.size() != self.vertex_count()) {
        refuse("vertices", "must be as many as the index has, " +
                               std::to_string(self.vertex_count()) + ", are " +
                               std::to_string(positions.size()));
    }
    if (!given.is_none() && !py::isinstance<MeshTopology>(given))
        refuse_object(given, "topology", "a proxima.Topology");
    const Topology* const topology =
        given.is_none() ? nullptr : &given.cast<const MeshTopology&>().topology;
    const Threads thread_count = threads_of(threads);
    return run(progress, Duration::lengthy, [&](Progress* watched) -> Result<MeshIndex> {
        const Execution execution{.threads = thread_count, .progress = watched};
        const auto before = mesh_of(self);
        if (!before) return tl::unexpected(before.error());
        const auto points = positions.points();
        const auto triangles = before->triangles();
        const auto mesh = make_triangle_mesh({points.begin(), points.end()},
                                             {triangles.begin(), triangles.end()});
        if (!mesh) return tl::unexpected(mesh.error());
        if (topology != nullptr)
            return refit_index(self, *mesh, *topology, {.execution = execution});
        const auto built = build_topology(*mesh, {.execution = execution});
        if (!built) return tl::unexpected(built.error());
        return refit_index(self, *mesh, *built, {.execution = execution});
    });
}

std::string represent_index(const MeshIndex& index)
{
    std::string text = "<proxima.Index: " + std::to_string(index.triangle_count()) + " triangles";
    if (index.has_lists()) text += ", lists";
    if (index.has_slabs()) text += ", distances";
    if (index.has_signs()) text += ", signs";
    return text + ", " + std::to_string(index.bytes()) + " bytes>";
}

} // namespace

MeshIndex index_of(const py::object& model, const char* wanted)
{
    if (py::isinstance<MeshIndex>(model)) return model.cast<const MeshIndex&>();
    if (!py::isinstance<TriangleMesh>(model)) refuse_object(model, "model", wanted);
    const auto& mesh = model.cast<const TriangleMesh&>();
    return run(py::none(), Duration::lengthy, [&](Progress* watched) {
        return build_mesh_index(mesh, {.execution = {.progress = watched}});
    });
}

void bind_index(py::module_& module)
{
    py::class_<MeshIndex> index(module, "Index",
                                R"(The index of a mesh: built once, it answers every query.

Index(mesh, *, lists=False, distances=False, signs=False, threads=0, progress=None)

    lists      True, or their largest size in bytes: closest features in bounded time, about 100 us of work and 520
               bytes per triangle
    distances  True: distances between meshes are found sooner, 3 bytes per triangle
    signs      True: tells inside from outside, needed by signed_distance; 3 to 10 us of work per triangle
    threads    0 = all of the machine; results never depend on it
    progress   called as progress(stage, fraction) twenty times a second; returning False raises Cancelled

Immutable; holds a copy of the triangles; any number of threads may query it. About 0.5 us of work and 120 bytes per
triangle, 160 where positions are not floats. Ctrl-C stops building and batches. Raises InvalidInput for a mesh without
triangles or with NaN.)");
    index
        .def(py::init(&index_of_mesh), py::arg("mesh"), py::kw_only(), py::arg("lists") = false,
             py::arg("distances") = false, py::arg("signs") = false, py::arg("threads") = 0,
             py::arg("progress") = py::none())
        .def("save", &save_index, py::arg("path"), py::kw_only(), py::arg("progress") = py::none(),
             "Writes the index with all that it has to a .pxi file, whole or not at all.")
        .def_static("load", &load, py::arg("path"), py::kw_only(), py::arg("map") = false,
                    py::arg("progress") = py::none(),
                    R"(The index of a .pxi file.

map=True uses the file's own pages, which processes share: the file must not be shortened meanwhile. Raises FileMissing,
or InvalidInput for a file that is damaged or none of ours.)")
        .def(
            "with_lists",
            [](const MeshIndex& self, const py::object& lists, Integer threads,
               const py::object& progress) {
                ListOptions options = list_options_of(lists).value_or(ListOptions{});
                options.execution.threads = threads_of(threads);
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    options.execution.progress = watched;
                    return proxima::with_lists(self, options);
                });
            },
            py::arg("lists") = true, py::kw_only(), py::arg("threads") = 0,
            py::arg("progress") = py::none(),
            "The index with closest-feature lists; shares all else. See Index for `lists`.")
        .def(
            "with_distances",
            [](const MeshIndex& self, Integer threads, const py::object& progress) {
                const Threads thread_count = threads_of(threads);
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    return with_slabs(
                        self, {.execution = {.threads = thread_count, .progress = watched}});
                });
            },
            py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none(),
            "The index with what makes distances between meshes faster; shares all else.")
        .def(
            "with_signs",
            [](const MeshIndex& self, Integer threads, const py::object& progress) {
                const Threads thread_count = threads_of(threads);
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    return proxima::with_signs(
                        self, {.execution = {.threads = thread_count, .progress = watched}});
                });
            },
            py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none(),
            "The index with signs, which signed_distance needs; shares all else.")
        .def(
            "refit", &refit, py::arg("vertices"), py::kw_only(), py::arg("topology") = py::none(),
            py::arg("threads") = 0, py::arg("progress") = py::none(),
            R"(The index of the mesh with its vertices elsewhere, for bodies that bend: sooner than a new one.

    vertices  (V, 3) floats, one for each vertex of the mesh, whose triangles stay
    topology  the Topology of the mesh, to save building it in every call

With lists where this one has some, without distances and signs. Answers are exact; queries are slower the farther
neighbours moved apart. The index itself stays as it was. A refit with lists cannot be saved. Up to a microsecond per
triangle. Raises InvalidInput for another number of vertices, NaN, another mesh's topology, and vertices outside of what
lists were built for: then build anew.)")
        .def_property_readonly("triangle_count", &MeshIndex::triangle_count)
        .def_property_readonly("vertex_count", &MeshIndex::vertex_count)
        .def_property_readonly("edge_count", &MeshIndex::edge_count)
        .def_property_readonly("fingerprint", &MeshIndex::mesh_fingerprint,
                               "int: Mesh.fingerprint of the mesh that it was built from.")
        .def_property_readonly("nbytes", &MeshIndex::bytes,
                               "Bytes of all arrays, including those shared with other indexes.")
        .def_property_readonly("has_lists", &MeshIndex::has_lists)
        .def_property_readonly("has_distances", &MeshIndex::has_slabs)
        .def_property_readonly("has_signs", &MeshIndex::has_signs)
        .def(
            "mesh", [](const MeshIndex& self) { return value_of(mesh_of(self)); },
            "The mesh that it was built from. Vertices without a triangle stand at the index's "
            "centre: "
            "then the fingerprint is another one.")
        .def("__repr__", &represent_index)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def(py::pickle(
            [](const MeshIndex& self) {
                return bytes_of_file(
                    [&](const std::filesystem::path& path) { save_index(self, path, py::none()); });
            },
            [](const py::bytes& pickled) {
                const FileBytes file = file_bytes_of(pickled);
                return value_of(load_index(file.bytes, file.storage, "pickled index"));
            }));
    bind_closest(index);
    bind_rays(index);
    bind_views(module, index);
    bind_pairs(index);
    bind_contact(index);
    bind_near(index);
    bind_field(index);
    bind_comparisons(module, index);
    bind_motions(module, index);
}

} // namespace proxima::python
