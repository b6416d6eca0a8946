#include "proxima/octree.h"
#include "arrays.h"
#include "bindings.h"
#include "pickled.h"
#include "proxima/octree_io.h"
#include "run.h"
#include "unlocked.h"

#include <filesystem>
#include <limits>
#include <pybind11/stl/filesystem.h>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// Sets the root of an argument: "cube", "box", or a box.
void set_root(OctreeOptions& options, const py::object& root)
{
    if (!py::isinstance<py::str>(root)) {
        const PointsArgument corners(root, "root");
        if (corners.size() != 2)
            refuse("root", R"(must be "cube", "box", or lowest and highest corner, (2, 3))");
        options.root = OctreeFrame{corners.points()[0], corners.points()[1] - corners.points()[0]};
        return;
    }
    const std::string name = text_of(root);
    if (name != "cube" && name != "box")
        refuse("root", R"(must be "cube", "box" or a box, is ")" + name + "\"");
    options.root_shape = name == "cube" ? RootShape::cube : RootShape::box;
}

Octree octree_of_mesh(const TriangleMesh& mesh, Integer max_depth, Integer threshold, bool uniform,
                      const py::object& root, bool classify, Integer threads,
                      const py::object& progress)
{
    constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
    OctreeOptions options{
        .max_depth = static_cast<int>(count_of(max_depth, "max_depth", max_octree_depth)),
        .threshold = static_cast<std::uint32_t>(count_of(threshold, "threshold", most)),
        .subdivision = uniform ? Subdivision::uniform : Subdivision::adaptive,
        .classification = classify ? Classification::inner_outer : Classification::none,
        .execution = {.threads = threads_of(threads)}};
    set_root(options, root);
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        options.execution.progress = watched;
        return build_octree(mesh, options);
    });
}

py::dict statistics_of(const Octree& octree)
{
    const OctreeStatistics counts = octree_statistics(octree);
    py::dict all;
    all["total"] = counts.total;
    all["leaves"] = counts.leaves;
    all["occupied_leaves"] = counts.occupied_leaves;
    all["occupied_percent"] = counts.occupied_percent;
    all["min_triangles"] = counts.min_triangles;
    all["max_triangles"] = counts.max_triangles;
    all["references"] = counts.references;
    all["mean_triangles"] = counts.mean_triangles;
    all["std_triangles"] = counts.std_triangles;
    all["mean_all_leaves"] = counts.mean_all_leaves;
    all["std_all_leaves"] = counts.std_all_leaves;
    all["inner"] = counts.inner;
    all["outer"] = counts.outer;
    all["boundary"] = counts.boundary;
    all["unclassified"] = counts.unclassified;
    all["depth_reached"] = counts.depth_reached;
    all["bytes"] = counts.bytes;
    return all;
}

/// Writes leaves to arrays of the right size.
struct LeafWriter {
    const Octree& octree;
    std::uint64_t* keys;
    std::uint8_t* depths;
    std::uint8_t* kinds;
    Vec3* lower;
    Vec3* upper;
    std::int64_t* first;
    std::int32_t* triangles;
    std::size_t leaf = 0;
    std::int64_t written = 0;

    [[nodiscard]] static bool should_enter(const Cell&) { return true; }

    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> ids)
    {
        const Box box = octree.box(cell);
        keys[leaf] = cell.key.bits;
        depths[leaf] = static_cast<std::uint8_t>(depth(cell.key));
        kinds[leaf] = static_cast<std::uint8_t>(cell.type);
        lower[leaf] = box.lower;
        upper[leaf] = box.upper;
        for (const TriangleId id : ids)
            triangles[written++] = static_cast<std::int32_t>(to_index(id));
        first[++leaf] = written;
        return Flow::proceed;
    }
};

py::object leaves_of(const Octree& octree)
{
    const OctreeStatistics counts = octree_statistics(octree);
    auto keys = new_array<std::uint64_t>(counts.leaves);
    auto depths = new_array<std::uint8_t>(counts.leaves);
    auto kinds = new_array<std::uint8_t>(counts.leaves);
    auto lower = new_rows<double>(counts.leaves, 3);
    auto upper = new_rows<double>(counts.leaves, 3);
    auto first = new_array<std::int64_t>(counts.leaves + 1);
    auto triangles = new_array<std::int32_t>(counts.references);
    LeafWriter writer{octree,
                      keys.mutable_data(),
                      depths.mutable_data(),
                      kinds.mutable_data(),
                      elements_of<Vec3>(lower).data(),
                      elements_of<Vec3>(upper).data(),
                      first.mutable_data(),
                      triangles.mutable_data()};
    first.mutable_data()[0] = 0;
    {
        const Unlocked unlocked;
        traverse(octree, writer);
    }
    return result_type("Leaves")(keys, depths, kinds, lower, upper, first, triangles);
}

void save_octree(const Octree& octree, const std::filesystem::path& path,
                 const py::object& progress)
{
    run(progress, Duration::lengthy, [&](Progress* watched) {
        return save_octree(octree, path, {.execution = {.progress = watched}});
    });
}

std::string represent_octree(const Octree& octree)
{
    const OctreeStatistics counts = octree_statistics(octree);
    return "<proxima.Octree: " + std::to_string(counts.leaves) + " leaves, " +
           std::to_string(counts.boundary) + " at the boundary, depth " +
           std::to_string(counts.depth_reached) + ">";
}

} // namespace

void bind_octree(py::module_& module)
{
    py::class_<Octree> octree(
        module, "Octree",
        R"(The octree of a mesh: cells, and the triangles that touch them. Immutable.

Octree(mesh, *, max_depth=5, threshold=1, uniform=False, root="cube", classify=True, threads=0, progress=None)

    max_depth  0 to 19; the root is depth 0
    threshold  a cell splits if more triangles touch it and it may be deeper
    uniform    True: all cells split to max_depth
    root       "cube" or "box", tight around the mesh, or lowest and highest corner of a box that holds it, (2, 3)
    classify   True: finds which empty leaves are inside

Raises InvalidInput for a mesh without triangles or with NaN, or one that leaves the root; LimitExceeded where memory
does not suffice.)");
    octree
        .def(py::init(&octree_of_mesh), py::arg("mesh"), py::kw_only(), py::arg("max_depth") = 5,
             py::arg("threshold") = 1U, py::arg("uniform") = false, py::arg("root") = "cube",
             py::arg("classify") = true, py::arg("threads") = 0, py::arg("progress") = py::none())
        .def("leaves", &leaves_of,
             "All leaves in Morton order, empty ones included, as Leaves: arrays by column.")
        .def_property_readonly(
            "statistics", &statistics_of,
            "Counts of cells and lists, as `proxima octree` prints them: a dict.")
        .def("save", &save_octree, py::arg("path"), py::kw_only(), py::arg("progress") = py::none(),
             "Writes a .pxo file, whole or not at all.")
        .def_static(
            "load",
            [](const std::filesystem::path& path, const py::object& progress) {
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    return load_octree(path, {.execution = {.progress = watched}});
                });
            },
            py::arg("path"), py::kw_only(), py::arg("progress") = py::none(),
            "The octree of a .pxo file. Raises FileMissing, or InvalidInput for a damaged one.")
        .def(
            "export",
            [](const Octree& self, const TriangleMesh& mesh, const std::filesystem::path& path,
               const py::object& progress) {
                run(progress, Duration::lengthy, [&](Progress* watched) {
                    return export_octree(self, mesh, path, {.execution = {.progress = watched}});
                });
            },
            py::arg("mesh"), py::arg("path"), py::kw_only(), py::arg("progress") = py::none(),
            "Writes .vtu, .htg, .ply or .glb for other programs. `mesh` is the octree's own.")
        .def("__repr__", &represent_octree)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def(py::pickle(
            [](const Octree& self) {
                return bytes_of_file([&](const std::filesystem::path& path) {
                    save_octree(self, path, py::none());
                });
            },
            [](const py::bytes& pickled) {
                const FileBytes file = file_bytes_of(pickled);
                return value_of(load_octree(file.bytes, file.storage, "pickled octree"));
            }));
    bind_octree_cells(octree);
}

} // namespace proxima::python
