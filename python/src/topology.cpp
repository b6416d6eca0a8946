#include "arrays.h"
#include "bindings.h"
#include "mesh_topology.h"
#include "proxima/neighbourhood.h"
#include "run.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

MeshTopology topology_of_mesh(const py::object& mesh, Integer threads, const py::object& progress)
{
    if (!py::isinstance<TriangleMesh>(mesh)) refuse_object(mesh, "mesh", "a proxima.Mesh");
    MeshTopology built{mesh, &mesh.cast<const TriangleMesh&>(), {}};
    const Threads thread_count = threads_of(threads);
    built.topology = run(progress, Duration::lengthy, [&](Progress* watched) {
        return build_topology(*built.mesh,
                              {.execution = {.threads = thread_count, .progress = watched}});
    });
    return built;
}

py::array edges_of(const MeshTopology& self)
{
    auto array = new_rows<std::int32_t>(self.topology.edge_count(), 2);
    std::int32_t* to = array.mutable_data();
    for (std::uint32_t edge = 0; edge < self.topology.edge_count(); ++edge) {
        for (const VertexId vertex : self.topology.vertices(EdgeId{edge}))
            *to++ = static_cast<std::int32_t>(to_index(vertex));
    }
    return array;
}

py::array neighbours_of(const MeshTopology& self)
{
    auto array = new_rows<std::int32_t>(self.topology.triangle_count(), 3);
    std::int32_t* to = array.mutable_data();
    for (std::uint32_t triangle = 0; triangle < self.topology.triangle_count(); ++triangle) {
        for (int side = 0; side < 3; ++side) {
            const TriangleId other = self.topology.across(TriangleId{triangle}, side);
            *to++ = static_cast<std::int32_t>(to_index(other));
        }
    }
    return array;
}

std::vector<Feature> features_of(const py::object& closest, const Topology& topology)
{
    if (!py::hasattr(closest, "feature_kind") || !py::hasattr(closest, "feature"))
        refuse_object(closest, "closest", "a proxima.Closest or ClosestOne");
    const char* const column = "integers: a column of Closest, or a number";
    const auto kinds = integers_of(closest.attr("feature_kind"), "closest.feature_kind", column);
    const auto ids = integers_of(closest.attr("feature"), "closest.feature", column);
    if (kinds.size() != ids.size()) refuse("closest", "has columns of different lengths");
    std::vector<Feature> features(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
        if (kinds[i] < 0 || kinds[i] > 2) {
            refuse("closest.feature_kind", "row " + std::to_string(i) + " must be 0, 1 or 2, is " +
                                               std::to_string(kinds[i]));
        }
        const auto kind = static_cast<FeatureKind>(kinds[i]);
        const std::size_t count = kind == FeatureKind::vertex ? topology.vertex_count()
                                  : kind == FeatureKind::edge ? topology.edge_count()
                                                              : topology.triangle_count();
        if (ids[i] < 0 || static_cast<std::uint64_t>(ids[i]) >= count) {
            refuse("closest.feature", "row " + std::to_string(i) + " must be below " +
                                          std::to_string(count) + ", is " + std::to_string(ids[i]));
        }
        features[i] = {kind, static_cast<std::uint32_t>(ids[i])};
    }
    return features;
}

py::object patch(const MeshTopology& self, const py::object& closest, Integer rings,
                 const py::object& progress)
{
    const std::uint64_t ring_count = count_of(rings, "rings");
    const std::vector<Feature> features = features_of(closest, self.topology);
    std::vector<std::size_t> first{0};
    std::vector<TriangleId> triangles;
    std::vector<std::int32_t> ring_of;
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        watched->begin_stage("rings of triangles", features.size());
        NeighbourhoodScratch scratch(*self.mesh);
        std::vector<TriangleId> buffer(std::min<std::size_t>(self.mesh->triangle_count(), 1024));
        // Beyond as many rings as there are triangles nothing is added.
        const int enough =
            static_cast<int>(std::min<std::uint64_t>(ring_count, self.mesh->triangle_count()));
        std::vector<std::size_t> ends(static_cast<std::size_t>(enough) + 1);
        for (const Feature& feature : features) {
            const auto collect = [&] {
                return collect_rings(*self.mesh, self.topology, feature, enough, scratch, buffer,
                                     ends);
            };
            Neighbourhood found = collect();
            if (!found.complete) {
                buffer.resize(self.mesh->triangle_count());
                found = collect();
            }
            triangles.insert(triangles.end(), buffer.begin(),
                             buffer.begin() + static_cast<std::ptrdiff_t>(found.written));
            for (std::size_t ring = 0; ring < ends.size(); ++ring)
                ring_of.resize(first.back() + ends[ring], static_cast<std::int32_t>(ring));
            first.push_back(triangles.size());
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            watched->advance(1);
        }
        return {};
    });
    return result_type("Patches")(array_of<std::int64_t>(std::span<const std::size_t>(first)),
                                  array_of<std::int32_t>(std::span<const TriangleId>(triangles)),
                                  array_of<std::int32_t>(std::span<const std::int32_t>(ring_of)));
}

std::string represent_topology(const MeshTopology& self)
{
    return "<proxima.Topology: " + std::to_string(self.topology.vertex_count()) + " vertices, " +
           std::to_string(self.topology.edge_count()) + " edges, " +
           std::to_string(self.topology.triangle_count()) + " triangles>";
}

} // namespace

void bind_topology(py::module_& module)
{
    py::class_<MeshTopology>(
        module, "Topology",
        R"(The edges of a mesh, and which triangles meet at them and at vertices.

Topology(mesh, *, threads=0, progress=None)

Works for any mesh, manifold or not. Triangles are neighbours where they share ids of vertices, whatever the positions. Keeps the mesh alive. Immutable; any number of threads may use it.
70 bytes per triangle.)")
        .def(py::init(&topology_of_mesh), py::arg("mesh"), py::kw_only(), py::arg("threads") = 0,
             py::arg("progress") = py::none())
        .def_property_readonly("edges", &edges_of,
                               "(E, 2) int32: the vertices of each edge, ascending; edges in the "
                               "order of the ids of Closest.feature.")
        .def_property_readonly(
            "neighbours", &neighbours_of,
            R"((F, 3) int32: the triangle across side k, from corner k to corner k + 1; -1 on a boundary and where three or
more triangles meet.)")
        .def("patch", &patch, py::arg("closest"), py::arg("rings") = 1, py::kw_only(),
             py::arg("progress") = py::none(),
             R"(Triangles round closest features, ring by ring, as Patches.

    closest  a Closest or ClosestOne of this mesh: its feature_kind and feature are used
    rings    0: the triangles that have the feature; each ring adds those that share a vertex with the ring before

Raises InvalidInput where a feature is none of this mesh.)")
        .def("__repr__", &represent_topology)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def("__reduce__", [](const py::object& self) {
            return py::make_tuple(self.attr("__class__"),
                                  py::make_tuple(self.cast<const MeshTopology&>().owner));
        });
}

} // namespace proxima::python
