// The structures and methods of the thesis as it describes them, each beside the library's own: for
// comparisons, and to follow the text.
//
//     auto octree = build_octree_by(mesh, {.method = OverlapMethod::index_tracking}, {.max_depth = 5});
//     auto sum = minkowski_sum_by(MinkowskiMethod::geometric, a, b);
//     auto proximity = build_thesis_proximity(convex_mesh, {.max_depth = 5});
//     auto closest = closest_feature(*proximity, point);
//
// All of them are slower than what the other headers offer: docs/thesis.md has measurements.
#pragma once

#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/minkowski_sum.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "proxima/view_volume.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace PROXIMA_EXPORT proxima {

// Octrees (2.1, 3.4 to 3.7).

/// Whether the thesis's methods may err by rounding. OverlapMethod::fast never does.
enum class Exactness : std::uint8_t {
    rounded, ///< as the arithmetic of doubles has it
    exact    ///< exactly the triangles that touch the closed cell, whatever the method
};

/// An overlap test, and how far it is trusted.
struct OverlapChoice {
    OverlapMethod method = OverlapMethod::fast;
    Exactness exactness = Exactness::rounded;
};

/// Like build_octree, with the lists that the chosen test finds. Errors and determinism as
/// build_octree; the thesis's tests take 10 to 10,000 times as long as OverlapMethod::fast
/// (`proxima compare` measures them).
[[nodiscard]] Result<Octree> build_octree_by(const TriangleMesh& mesh, const OverlapChoice& choice,
                                             const OctreeOptions& options = {});

/// The heuristic of thesis 2.1.1: builds with the given threshold, then again with the largest
/// number of triangles found in a leaf, which saves cells without longer worst lists.
/// The second octree's parameters().threshold is that number. Errors as build_octree.
[[nodiscard]] Result<Octree> build_octree_two_pass(const TriangleMesh& mesh,
                                                   const OverlapChoice& choice = {},
                                                   const OctreeOptions& options = {});

// Minkowski sums (3.2, 3.3).

/// How a sum is found. All three give the same one, but for rounding in the last two.
enum class MinkowskiMethod : std::uint8_t {
    arcs,      ///< minkowski_sum: overlay of the Gaussian maps; exact; the fast one
    geometric, ///< the thesis's pushing of planes (3.2); slow for more than a few dozen facets
    hull       ///< incremental hull of all pairs (3.3.2); slow for more than some hundred pairs
};

/// The sum of A and B. Errors: as minkowski_sum; of geometric and hull also invalid_argument
/// (unbounded operands; a flat sum; rounding broke the hull) and
/// limit_exceeded (operands so large that they would take hours).
[[nodiscard]] Result<MinkowskiSum> minkowski_sum_by(MinkowskiMethod method,
                                                    const ConvexPolyhedron& a,
                                                    const ConvexPolyhedron& b,
                                                    const MinkowskiOptions& options = {});

// Closest features of a convex mesh (4.3).

/// A cell splits while it lists more features of any kind than these; 0 splits all but inner ones.
struct KindThresholds {
    std::uint32_t vertex = 1;
    std::uint32_t edge = 1;
    std::uint32_t face = 1;

    [[nodiscard]] std::uint32_t of(FeatureKind kind) const noexcept
    {
        switch (kind) {
        case FeatureKind::vertex:
            return vertex;
        case FeatureKind::edge:
            return edge;
        case FeatureKind::face:
            break;
        }
        return face;
    }
    friend bool operator==(const KindThresholds&, const KindThresholds&) = default;
};

/// The most that a root may be larger than the mesh.
inline constexpr double max_root_margin = 1e6;

struct ThesisProximityOptions {
    int max_depth = 5; ///< 0 to max_octree_depth; the root is depth 0
    KindThresholds thresholds = {};
    double margin = 0.5; ///< root edge = (1 + margin) times the tight cube's; 0 to max_root_margin
    double convexity_tolerance = 1e-9; ///< of vertices beyond a face, per diagonal of the mesh
    double flat_sine = 1e-8;           ///< of the angle up to which faces count as one plane
    Execution execution = {};          ///< budget: result and scratch, without mesh and topology
};

struct ThesisProximityParts;

/// The thesis's proximity octree of a convex mesh, with the mesh. Its cells list the features whose
/// exterior Voronoi regions they meet. Immutable and cheap to copy. Thread safe. Made by
/// build_thesis_proximity.
class ThesisProximity {
public:
    /// The depth of the deepest leaf: no search takes more steps.
    [[nodiscard]] int depth_reached() const noexcept;
    /// Bytes of cells and lists, without the mesh.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// For the library's own searches.
    [[nodiscard]] const ThesisProximityParts& parts() const noexcept { return *parts_; }
    /// For the library's own builders. \pre parts is not null
    explicit ThesisProximity(std::shared_ptr<const ThesisProximityParts> parts) noexcept;

    // Copies only: a moved-from one would have no parts.
    ThesisProximity(const ThesisProximity&) noexcept = default;
    ThesisProximity& operator=(const ThesisProximity&) noexcept = default;
    ~ThesisProximity() = default;

private:
    std::shared_ptr<const ThesisProximityParts> parts_; ///< never null
};

/// Keeps the mesh: hand it over by std::move, or it is copied. The same bits for any number of
/// threads. Errors: invalid_argument (depth, margin, tolerances), invalid_mesh (not closed, not
/// convex, NaN, coordinates beyond 1e100), limit_exceeded (2^31 cells or 2^32 labels),
/// budget_exceeded, cancelled. Some ten microseconds per feature, and some ten nanoseconds per label
/// of a cell and child.
[[nodiscard]] Result<ThesisProximity>
build_thesis_proximity(TriangleMesh mesh, const ThesisProximityOptions& options = {});

/// The closest feature, by the distances to all that the cell of the point lists; nothing for a
/// point outside the root, one inside the mesh (the thesis labels only what is outside), and NaN. At
/// most depth_reached() steps and the longest list. Thread safe, no allocation.
[[nodiscard]] std::optional<ClosestFeature> closest_feature(const ThesisProximity& proximity,
                                                            const Vec3& point) noexcept;

// Rays, culling and intersections by the cells of an octree (5.2 to 5.4).

/// The answer of closest_hit. Of a line that touches the root cell in a single point every triangle is
/// asked. Thread safe, no allocation. \pre the octree was built from this mesh, and lists exactly
/// the triangles that touch (OctreeParameters::exact); directions are so long that t is below 2^1000
/// all over the root
[[nodiscard]] std::optional<RayHit> closest_hit_by_cells(const Octree& octree,
                                                         const TriangleMesh& mesh, const Ray& ray,
                                                         Faces faces = Faces::both) noexcept;

/// What a walk over the cells found.
struct CellCulling {
    std::vector<TriangleId> triangles; ///< ascending, each once
    std::uint64_t cells = 0;           ///< visible leaves that hold triangles
};

/// The triangles of all leaves that the volume intersects: every triangle that has a point in common
/// with the volume, and neighbours of these in the same leaves. visible_triangles is faster and
/// tests triangles too. Thread safe, allocates the list and a bit per triangle.
/// \pre leaves list all triangles that touch them
[[nodiscard]] CellCulling cull_by_cells(const Octree& octree, const ViewVolume& volume);

/// A mesh and its octree, whose leaves list all triangles that touch them.
struct MeshCells {
    const TriangleMesh& mesh;
    const Octree& octree;
};

/// The pairs and what finding them took.
struct CellIntersection {
    std::vector<TrianglePair> pairs;  ///< by a, then b, each once
    std::uint64_t cell_tests = 0;     ///< of a cell against a cell
    std::uint64_t cell_pairs = 0;     ///< leaves that meet
    std::uint64_t triangle_tests = 0; ///< pairs of triangles, each once
};

/// The pairs that intersecting_pairs finds. Thread safe. Allocates the pairs, 8 bytes for each pair of
/// leaves that meet, and some for each triangle and place where it is listed.
[[nodiscard]] CellIntersection intersect_by_cells(const MeshCells& a, const MeshCells& b,
                                                  const RigidTransform& pose_b = {});

} // namespace proxima
