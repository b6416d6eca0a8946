// What is wrong with a mesh, where, and what it means for the queries.
//
//     const auto report = report_mesh(mesh);
//     for (const MeshFinding& finding : report->findings) {
//         std::cout << finding.count << ' ' << name_of(finding.kind) << ": " << finding.meaning;
//     }
//     for (const QueryOutlook& query : report->outlook) ...   // octree: works, sign: with care, ...
//
// Whether the surface intersects itself is not examined: find_self_intersections() does that.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace PROXIMA_EXPORT proxima {

class Topology;

/// In the order of the report. "Triangles" of the kinds from zero_area_triangles on are proper
/// ones: three different vertex ids. A degenerate triangle is neither a neighbour nor a component.
enum class FindingKind : std::uint8_t {
    no_triangles,
    non_finite_positions, ///< vertices with a NaN or infinite coordinate
    extreme_scale,        ///< so small or large that products of lengths leave double's range
    far_from_origin,      ///< see far_from_origin_ratio
    unreferenced_vertices,
    duplicate_vertices,    ///< at the position of an earlier vertex
    degenerate_triangles,  ///< a vertex id twice
    zero_area_triangles,   ///< corners exactly on one line
    duplicate_triangles,   ///< the vertex ids of an earlier triangle, in any order
    coincident_triangles,  ///< the positions of an earlier triangle, not its vertex ids
    boundary_edges,        ///< edges of one triangle
    non_manifold_edges,    ///< edges of three or more triangles
    non_manifold_vertices, ///< several fans meet: not all triangles connected by edges at the
                           ///< vertex
    inconsistent_edges,    ///< of an even number of triangles, not half of them in each direction
    inward_components      ///< closed, consistently oriented, of negative volume
};

enum class Severity : std::uint8_t {
    note,    ///< no query is worse off
    warning, ///< some answers mean less or need care
    error    ///< builders refuse the mesh
};

/// What a finding counts and its ids number.
enum class ElementKind : std::uint8_t {
    mesh,     ///< one finding about the whole; no ids
    vertex,   ///< vertex ids
    edge,     ///< edge ids of the topology
    triangle, ///< triangle ids
    component ///< each given by its lowest triangle id
};

struct MeshFinding {
    FindingKind kind{};
    Severity severity{};
    ElementKind element{};
    std::uint64_t count = 0;
    std::vector<std::uint32_t> first_ids; ///< the lowest ones, ascending
    std::vector<Vec3> first_positions; ///< vertex, edge midpoint or centroid of each of first_ids
    std::string meaning;               ///< what it is, and what it means for the queries
};

enum class QueryKind : std::uint8_t {
    octree,
    cell_classes, ///< inner and outer leaves
    closest_feature,
    sign,
    rays,
    intersection
};

enum class Outlook : std::uint8_t { works, with_care, refused };

/// What to expect of one kind of query on this mesh.
struct QueryOutlook {
    QueryKind query{};
    Outlook outlook{};
    std::string reason;
};

/// Which way the triangles of a closed, consistently oriented mesh face.
enum class Orientation : std::uint8_t {
    undefined, ///< not closed, not consistent, or no volume to speak of
    outward,   ///< every component has positive volume
    inward,    ///< every component has negative volume
    mixed      ///< some of each: cavities, or parts turned inside out
};

struct MeshReport {
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    std::uint64_t edges = 0;          ///< distinct pairs of vertices that a triangle joins
    std::uint64_t components = 0;     ///< sets of triangles connected across edges
    std::uint64_t boundary_loops = 0; ///< sets of boundary edges connected by vertices
    Box bounds;                       ///< of the finite positions that triangles use
    double area = 0.0;                ///< of the triangles with finite corners
    double min_edge_length = 0.0;     ///< of the edges with finite ends, 0 without any
    double max_edge_length = 0.0;

    /// Every edge has an even number of triangles: the surface encloses something.
    bool closed = false;
    /// On every edge of an even number of triangles, half of them run in each direction.
    bool consistently_oriented = false;
    /// For an open mesh with duplicate vertices: whether it would be closed without duplicates.
    std::optional<bool> closed_if_welded;
    Orientation orientation = Orientation::undefined;
    std::optional<double> signed_volume; ///< of closed, consistently oriented, finite meshes

    /// Vertices - edges + triangles, of what proper triangles use.
    std::int64_t euler_characteristic = 0;
    /// Number of handles of all components together, where closed, manifold and consistent.
    std::optional<std::int64_t> genus;

    std::vector<MeshFinding> findings; ///< only what was found, in the order of FindingKind
    std::vector<QueryOutlook> outlook; ///< one for every QueryKind, in their order

    /// The finding of a kind, nullptr where there is none.
    [[nodiscard]] const MeshFinding* find(FindingKind kind) const noexcept;
};

/// A mesh this many times as far from the origin as it is large is reported as far_from_origin.
inline constexpr double far_from_origin_ratio = 1e6;

struct MeshReportOptions {
    std::size_t max_ids = 5;  ///< elements that each finding names
    Execution execution = {}; ///< budget: scratch, topology included where it is built here
};

/// Examines any mesh, NaN and all. The same for any number of threads. Errors: limit_exceeded
/// (see build_topology), budget_exceeded, cancelled. O(triangles), about a microsecond each.
[[nodiscard]] Result<MeshReport> report_mesh(const TriangleMesh& mesh,
                                             const MeshReportOptions& options = {});

/// The same where the mesh's topology is at hand. \pre topology is the mesh's
[[nodiscard]] Result<MeshReport> report_mesh(const TriangleMesh& mesh, const Topology& topology,
                                             const MeshReportOptions& options = {});

/// Names for output, as the enumerators: "boundary_edges", "warning", "with_care", ...
[[nodiscard]] std::string_view name_of(FindingKind kind) noexcept;
[[nodiscard]] std::string_view name_of(Severity severity) noexcept;
[[nodiscard]] std::string_view name_of(ElementKind element) noexcept;
[[nodiscard]] std::string_view name_of(QueryKind query) noexcept;
[[nodiscard]] std::string_view name_of(Outlook outlook) noexcept;
[[nodiscard]] std::string_view name_of(Orientation orientation) noexcept;

} // namespace proxima
