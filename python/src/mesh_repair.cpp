#include "proxima/mesh_repair.h"
#include "arrays.h"
#include "bindings.h"
#include "proxima/mesh_report.h"
#include "run.h"
#include "unlocked.h"

#include <optional>
#include <string>
#include <string_view>

namespace proxima::python {

namespace {

template <class T>
py::object optional_of(const std::optional<T>& value)
{
    return value ? py::cast(*value) : py::none();
}

py::object finding_of(const MeshFinding& finding)
{
    return result_type("Finding")(
        name_of(finding.kind), name_of(finding.severity), name_of(finding.element), finding.count,
        array_of<std::int32_t>(std::span<const std::uint32_t>(finding.first_ids)),
        rows_of(finding.first_positions), finding.meaning);
}

py::object report(const TriangleMesh& mesh, Integer max_ids, Integer threads,
                  const py::object& progress)
{
    const Threads thread_count = threads_of(threads);
    const std::size_t most_ids = count_of(max_ids, "max_ids");
    const MeshReport found = run(progress, Duration::lengthy, [&](Progress* watched) {
        return report_mesh(mesh, {.max_ids = most_ids,
                                  .execution = {.threads = thread_count, .progress = watched}});
    });
    py::list findings;
    for (const MeshFinding& finding : found.findings) findings.append(finding_of(finding));
    py::dict outlook;
    for (const QueryOutlook& query : found.outlook) {
        outlook[py::cast(name_of(query.query))] =
            py::make_tuple(name_of(query.outlook), query.reason);
    }
    const Vec3 bounds[] = {found.bounds.lower, found.bounds.upper};
    py::dict columns;
    columns["vertices"] = found.vertices;
    columns["triangles"] = found.triangles;
    columns["edges"] = found.edges;
    columns["components"] = found.components;
    columns["boundary_loops"] = found.boundary_loops;
    columns["bounds"] = rows_of(bounds);
    columns["area"] = found.area;
    columns["min_edge_length"] = found.min_edge_length;
    columns["max_edge_length"] = found.max_edge_length;
    columns["closed"] = found.closed;
    columns["consistently_oriented"] = found.consistently_oriented;
    columns["closed_if_welded"] = optional_of(found.closed_if_welded);
    columns["orientation"] = name_of(found.orientation);
    columns["volume"] = optional_of(found.signed_volume);
    columns["euler_characteristic"] = found.euler_characteristic;
    columns["genus"] = optional_of(found.genus);
    columns["findings"] = py::tuple(findings);
    columns["outlook"] = outlook;
    return result_type("Report")(**columns);
}

py::object repair(const TriangleMesh& mesh, const MeshRepairOptions& options, Integer threads,
                  const py::object& progress)
{
    MeshRepairOptions own = options;
    own.execution.threads = threads_of(threads);
    MeshRepair made = run(progress, Duration::lengthy, [&](Progress* watched) {
        own.execution.progress = watched;
        return repair_mesh(mesh, own);
    });
    py::dict steps;
    for (const RepairStep& step : made.steps)
        if (step.enabled) steps[py::cast(name_of(step.kind))] = step.count;
    py::dict columns;
    columns["mesh"] = std::move(made.mesh);
    columns["triangle"] =
        array_of<std::int32_t>(std::span<const TriangleId>(made.original_triangles));
    columns["vertex"] = array_of<std::int32_t>(std::span<const VertexId>(made.original_vertices));
    columns["turned"] = array_of<bool>(std::span<const std::uint8_t>(made.turned));
    columns["steps"] = steps;
    columns["pieces"] = made.pieces;
    columns["closed_pieces"] = made.closed_pieces;
    columns["cavities"] = made.cavities;
    columns["unorientable_pieces"] = made.unorientable_pieces;
    columns["unorientable_edges"] = made.unorientable_edges;
    return result_type("Repair")(**columns);
}

TriangleMesh weld(const TriangleMesh& mesh, const py::object& progress)
{
    return run(progress, Duration::lengthy,
               [&](Progress* watched) { return weld_vertices(mesh, {.progress = watched}); });
}

TriangleMesh part(const TriangleMesh& mesh, const py::object& triangles)
{
    std::vector<TriangleId> ids;
    for (const std::int64_t id : integers_of(triangles, "triangles")) {
        if (id < 0 || static_cast<std::uint64_t>(id) >= mesh.triangle_count()) {
            refuse("triangles",
                   "row " + std::to_string(ids.size()) + " must be 0 or more and below " +
                       std::to_string(mesh.triangle_count()) + ", is " + std::to_string(id));
        }
        ids.push_back(TriangleId{static_cast<std::uint32_t>(id)});
    }
    const Unlocked unlocked;
    return sub_mesh(mesh, ids);
}

} // namespace

void bind_mesh_repair(py::class_<TriangleMesh>& mesh)
{
    const MeshRepairOptions usual;
    mesh.def(
            "report", &report, py::arg("max_ids") = MeshReportOptions{}.max_ids, py::kw_only(),
            py::arg("threads") = 0, py::arg("progress") = py::none(),
            R"(What is wrong with the mesh, where, and what it means for the queries, as a Report: print it.

    max_ids  of the elements that each finding names

Takes any mesh, NaN and all; about a microsecond per triangle. Whether the surface passes through itself is not
examined: Index.self_intersections() does that. Any number of threads may call it.)")
        .def(
            "repair",
            [](const TriangleMesh& self, bool weld, double weld_distance, bool drop_non_finite,
               bool drop_degenerate, bool drop_zero_area, bool drop_duplicates,
               double min_component_area, Integer min_component_triangles, bool orient,
               bool turn_outward, bool keep_cavities, bool drop_unused_vertices, Integer threads,
               const py::object& progress) {
                return repair(self,
                              {.drop_non_finite = drop_non_finite,
                               .weld = weld,
                               .weld_distance = weld_distance,
                               .drop_degenerate = drop_degenerate,
                               .drop_zero_area = drop_zero_area,
                               .drop_duplicates = drop_duplicates,
                               .min_component_area = min_component_area,
                               .min_component_triangles =
                                   count_of(min_component_triangles, "min_component_triangles"),
                               .orient = orient,
                               .turn_outward = turn_outward,
                               .keep_cavities = keep_cavities,
                               .drop_unused_vertices = drop_unused_vertices},
                              threads, progress);
            },
            py::kw_only(), py::arg("weld") = usual.weld,
            py::arg("weld_distance") = usual.weld_distance,
            py::arg("drop_non_finite") = usual.drop_non_finite,
            py::arg("drop_degenerate") = usual.drop_degenerate,
            py::arg("drop_zero_area") = usual.drop_zero_area,
            py::arg("drop_duplicates") = usual.drop_duplicates,
            py::arg("min_component_area") = usual.min_component_area,
            py::arg("min_component_triangles") = usual.min_component_triangles,
            py::arg("orient") = usual.orient, py::arg("turn_outward") = usual.turn_outward,
            py::arg("keep_cavities") = usual.keep_cavities,
            py::arg("drop_unused_vertices") = usual.drop_unused_vertices, py::arg("threads") = 0,
            py::arg("progress") = py::none(),
            R"(A mesh with vertices welded, flawed triangles dropped and orientation mended, as a Repair.

    weld                     joins vertices at one position, and those at most weld_distance apart, in the mesh's unit
    drop_non_finite          triangles with a NaN or infinite corner
    drop_degenerate          triangles that name a vertex twice
    drop_zero_area           triangles of three vertices on one line; off, as it may leave a slit
    drop_duplicates          triangles of the vertices of an earlier one; walls between solids and folds keep both sides
    min_component_area       drops components of less than this fraction of the largest one's area, 0 to 1
    min_component_triangles  drops components of fewer triangles
    orient                   triangles of a piece face one way, that of most of them
    turn_outward             closed pieces face outward, cavities inward unless keep_cavities is False
    drop_unused_vertices     vertices that no triangle uses

No step invents a position or a triangle: holes and intersections stay. About a microsecond per triangle. The mesh itself
stays as it is; any number of threads may call it. Raises InvalidInput for a number out of range.)")
        .def("weld", &weld, py::kw_only(), py::arg("progress") = py::none(),
             "The mesh with one vertex per position: the first stays. Triangles keep their ids.")
        .def(
            "part", &part, py::arg("triangles"),
            R"(The mesh of these triangles, (n,) integers, in this order, with the vertices that they use.

Raises InvalidInput for an id that is none of the mesh's.)");
}

} // namespace proxima::python
