// Repairing meshes: vertices welded, flawed triangles dropped, orientation mended; triangles cut out.
//
//     const auto repair = repair_mesh(mesh, {.weld_distance = 1e-4});
//     for (const RepairStep& step : repair->steps) {
//         std::cout << name_of(step.kind) << ": " << step.count << '\n';
//     }
//     const Status written = write_mesh(repair->mesh, "repaired.ply");
//     repair->original_triangles[7];   // the id that triangle 7 had in `mesh`
//
// No step invents a position or a triangle: holes stay open and intersections stay. report_mesh()
// says what is left, find_self_intersections() where the surface passes through itself.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// The steps of repair_mesh in the order in which they are done. Each needs those before it:
/// distances need numbers; welding makes triangles degenerate, equal and neighbours; only a
/// neighbour can be turned to match; and what is dropped as small shall not make a cavity of what
/// it surrounded.
enum class RepairStepKind : std::uint8_t {
    drop_non_finite,       ///< triangles with a NaN or infinite corner
    weld_vertices,         ///< vertices joined to another one at their position or near it
    drop_degenerate,       ///< triangles that name a vertex twice
    drop_zero_area,        ///< triangles of three vertices that lie exactly on one line
    drop_duplicates,       ///< all but one, or one of each side, of triangles of the same vertices
    drop_small_components, ///< components smaller than asked for
    orient_pieces,         ///< triangles turned over to run as their neighbours do
    turn_outward,          ///< closed pieces turned over as a whole
    drop_unused_vertices   ///< vertices that no triangle uses, other than those welded to another
};

inline constexpr std::size_t repair_step_count = 9;

/// "drop_non_finite" and so on.
[[nodiscard]] std::string_view name_of(RepairStepKind kind) noexcept;

/// Which steps are done, and how. A component is a set of triangles connected across edges, as in
/// MeshReport. A piece is connected across edges of exactly two triangles: what a surface that
/// branches comes apart into. A piece is closed if at each of its edges as many of its triangles
/// run one way as the other.
struct MeshRepairOptions {
    bool drop_non_finite = true;

    bool weld = true;
    /// 0 joins vertices at exactly the same position. Otherwise also those at most this far apart,
    /// in the mesh's unit: going through the vertices by id, one becomes the nearest that was kept
    /// before, or is kept itself. So no corner moves farther than this, vertices left are farther
    /// apart, and chains of near vertices do not collapse. At most 1e300.
    double weld_distance = 0.0;

    bool drop_degenerate = true;
    /// Off, as a closed mesh without such a triangle has a slit.
    bool drop_zero_area = false;
    /// Of triangles of the same three vertices the first stays of those that face the way of most.
    /// Walls between solids, and folds, face both ways, with at most one triangle more one way than
    /// the other: of them the first of each way stays, but where that leaves more edges open, and in
    /// components that are double throughout. So closed meshes stay closed, but for sheets with two
    /// sides and for sets of two triangles or more in excess of those that face them.
    bool drop_duplicates = true;

    /// Components of less than this fraction of the largest one's area are dropped, 0 to 1.
    double min_component_area = 0.0;
    /// Components of fewer triangles are dropped.
    std::uint64_t min_component_triangles = 0;

    /// Has the triangles of a piece face one way: that of most of them, or of the first if they are
    /// as many. A piece with no such way (a Möbius strip) is oriented breadth first from its first
    /// triangle, and its edges that do not match are counted.
    bool orient = true;
    /// Has closed pieces face outward. Pieces without volume to speak of stay as they are.
    bool turn_outward = true;
    /// A closed piece inside an odd number of others is a cavity and faces inward, exactly decided;
    /// solids with walls in common count as one of the others. Inside is what has all its corners
    /// inside, those left out that it shares; what passes through another piece is not. Off, all face
    /// outward: for solids that happen to be inside each other.
    bool keep_cavities = true;

    bool drop_unused_vertices = true;

    Execution execution = {}; ///< budget: result and scratch
};

/// What one step did.
struct RepairStep {
    RepairStepKind kind{};
    bool enabled = false;    ///< false: it was switched off
    std::uint64_t count = 0; ///< vertices, triangles, components or pieces, as its kind says
};

/// A repaired mesh, and where its parts come from. Triangles and vertices keep their order.
struct MeshRepair {
    TriangleMesh mesh;
    std::vector<TriangleId> original_triangles; ///< by triangle: its id before; ascending
    std::vector<std::uint8_t> turned;           ///< by triangle: 1 if its last corners were swapped
    std::vector<VertexId> original_vertices;    ///< by vertex: the lowest id of those that became
                                                ///< it and have its position; ascending
    std::array<RepairStep, repair_step_count> steps; ///< all, in the order of RepairStepKind

    std::uint64_t pieces = 0;
    std::uint64_t closed_pieces = 0;
    std::uint64_t cavities = 0;            ///< closed pieces that were found inside others
    std::uint64_t unorientable_pieces = 0; ///< none if they were not to be oriented
    std::uint64_t unorientable_edges = 0;  ///< their edges whose triangles do not match

    [[nodiscard]] const RepairStep& step(RepairStepKind kind) const noexcept
    {
        return steps[static_cast<std::size_t>(kind)];
    }
};

/// Repairs any mesh, NaN and all. Repairing a result again changes nothing. The same for any number
/// of threads; thread safe. Expected near-linear in triangles and vertices: about 1 us per triangle
/// of a soup; where a closed piece's box is in another's, triangles are also compared with its
/// corners below them. About 260 bytes per triangle and 120 per vertex. Errors:
/// invalid_argument (a distance or fraction out of range), limit_exceeded (more than
/// max_topology_triangles), budget_exceeded, cancelled.
[[nodiscard]] Result<MeshRepair> repair_mesh(const TriangleMesh& mesh,
                                             const MeshRepairOptions& options = {});

/// The mesh with one vertex per position: vertices whose coordinates are equal are merged (0.0 ==
/// -0.0; NaNs of the same bits are equal too). The first vertex of a position stays, in its place
/// among the others. Triangles keep their order and number, degenerate ones too. Expected
/// O(vertices + triangles). Error: cancelled.
[[nodiscard]] Result<TriangleMesh> weld_vertices(const TriangleMesh& mesh,
                                                 const Execution& execution = {});

/// These triangles in this order, with the vertices that they use, which keep their order.
/// O(n log n) in the number of triangles named, whatever the mesh's. \pre the ids are the mesh's
[[nodiscard]] TriangleMesh sub_mesh(const TriangleMesh& mesh,
                                    std::span<const TriangleId> triangles);

} // namespace proxima
