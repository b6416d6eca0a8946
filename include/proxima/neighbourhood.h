// What lies round a point: by adjacency, rings of triangles (thesis 5.1.1), by distance, a metric
// patch or the nearest so many, or within a box.
//
//     NeighbourhoodScratch scratch(mesh);                   // once per mesh and thread
//     std::array<TriangleId, 256> buffer;
//     const Neighbourhood near =
//         collect_rings(mesh, topology, closest.feature, 2, scratch, buffer);
//     if (!near.complete) ...                               // the buffer was too small
//     for (const TriangleId id : std::span(buffer).first(near.written)) ...
//     const Neighbourhood within = collect_triangles(*index, point, 0.5, buffer);    // by distance
//
//     std::array<NearTriangle, 8> nearest;
//     const Neighbourhood eight = collect_nearest(*index, point, nearest);
//
// collect_... write to the caller's buffer, visit_... hand over what they find one by one. Nothing
// allocates, locks or throws. A buffer that is too small is never a silent cut: `complete` is false.
#pragma once

#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// How much of a buffer was filled.
struct Neighbourhood {
    std::size_t written = 0; ///< items, from the buffer's begin: how many there are is not counted
    bool complete = true;    ///< all there is was written
};

/// Marks of vertices and triangles, so that rings never need to be cleared: 4 bytes each. One query
/// at a time; for several threads one each.
class NeighbourhoodScratch {
public:
    /// Allocates for this mesh.
    explicit NeighbourhoodScratch(const TriangleMesh& mesh);

    [[nodiscard]] std::size_t vertex_count() const noexcept { return vertices_.size(); }
    [[nodiscard]] std::size_t triangle_count() const noexcept { return triangles_.size(); }

    /// Forgets all marks. O(1); once in 2^32 - 1 times, when the numbers of rounds are used up,
    /// O(mesh).
    void begin() noexcept;

    /// True the first time after begin().
    [[nodiscard]] bool mark(VertexId vertex) noexcept { return mark(vertices_[to_index(vertex)]); }
    [[nodiscard]] bool mark(TriangleId triangle) noexcept
    {
        return mark(triangles_[to_index(triangle)]);
    }

    /// For tests: as if so many rounds had passed.
    void set_round(std::uint32_t round) noexcept { round_ = round; }

private:
    [[nodiscard]] bool mark(std::uint32_t& last_round) const noexcept
    {
        if (last_round == round_) return false;
        last_round = round_;
        return true;
    }

    std::vector<std::uint32_t> vertices_;
    std::vector<std::uint32_t> triangles_;
    std::uint32_t round_ = 0;
};

/// Rings 0 to `rings` round a feature. Ring 0 are the triangles incident to it by topology, ring k
/// adds those that share a vertex id with one of ring k - 1. Written ring by ring, ids ascending
/// within each; what does not fit ends the search, and the last ring written has then some of its
/// triangles, in ascending order. `ring_ends[k]`, for all k in its range, is set to where ring k
/// ends in the buffer. O(triangles written times valence), sorting included.
/// \pre topology and scratch are the mesh's, the feature is one of its, rings >= 0
[[nodiscard]] Neighbourhood collect_rings(const TriangleMesh& mesh, const Topology& topology,
                                          const Feature& feature, int rings,
                                          NeighbourhoodScratch& scratch,
                                          std::span<TriangleId> buffer,
                                          std::span<std::size_t> ring_ends = {}) noexcept;

/// A feature and its squared distance; none yet by default.
struct NearestFeature {
    double squared = std::numeric_limits<double>::infinity();
    Feature feature = {FeatureKind::face, to_index(no_triangle)};

    /// The order of answers.
    friend constexpr bool operator<(const NearestFeature& a, const NearestFeature& b) noexcept
    {
        return a.squared != b.squared ? a.squared < b.squared : a.feature < b.feature;
    }
    friend constexpr bool operator==(const NearestFeature&, const NearestFeature&) = default;
};

/// All triangles whose squared distance from p, as closest_feature computes it, is at most
/// radius^2, ids ascending. Where they do not fit, some of them, nearer groups first. None where p
/// is not finite, or the radius NaN or below 0. Thread safe.
[[nodiscard]] Neighbourhood collect_triangles(const MeshIndex& index, const Vec3& p, double radius,
                                              std::span<TriangleId> buffer) noexcept;

/// Calls visitor(triangle, squared distance) for the same triangles, in no particular order, until it
/// stops. noexcept, as the visitor must be. Thread safe.
void visit_triangles(const MeshIndex& index, const Vec3& p, double radius,
                     FunctionRef<Flow(TriangleId, double)> visitor) noexcept;

/// All triangles that have a point in common with the box, both closed, ids ascending. Exact. Where
/// they do not fit, some of them. None where the box is empty or has a NaN. About 1 us, and 0.1 us per
/// triangle near. Thread safe.
[[nodiscard]] Neighbourhood collect_triangles(const MeshIndex& index, const Box& box,
                                              std::span<TriangleId> buffer) noexcept;

/// Calls visitor(triangle) for the same triangles, in no particular order, until it stops. noexcept,
/// as the visitor must be. Thread safe.
void visit_triangles(const MeshIndex& index, const Box& box,
                     FunctionRef<Flow(TriangleId)> visitor) noexcept;

/// A triangle and its squared distance; none yet by default.
struct NearTriangle {
    double squared_distance = std::numeric_limits<double>::infinity();
    TriangleId triangle = no_triangle;

    /// The order of answers.
    friend constexpr bool operator<(const NearTriangle& a, const NearTriangle& b) noexcept
    {
        return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                        : a.triangle < b.triangle;
    }
    friend constexpr bool operator==(const NearTriangle&, const NearTriangle&) = default;
};

/// The triangles nearest to p, no farther than the radius, as many as the buffer holds: by squared
/// distance, as closest_feature computes it, equal ones by id. `complete` where they are all within the
/// radius; not where the buffer was filled and the mesh has more triangles. None where p is not finite,
/// or the radius NaN or below 0. Some 0.5 us more per triangle than closest_feature. Thread safe.
[[nodiscard]] Neighbourhood
collect_nearest(const MeshIndex& index, const Vec3& p, std::span<NearTriangle> buffer,
                double radius = std::numeric_limits<double>::infinity()) noexcept;

/// Calls visitor(triangle, squared distance) for the triangles within the radius, the nearest first and
/// equal ones by id, until the visitor stops: for callers who can tell only from a triangle whether they
/// want another one. `batch` is scratch: each search of the index finds as many triangles as it holds,
/// and passes again over those visited before. The visitor must not touch it. A batch for as many
/// as are usually wanted needs one search, as collect_nearest does. Nothing where p is not finite, or the
/// radius NaN or below 0. noexcept, as the visitor must be. Thread safe. \pre the batch is not empty
void visit_nearest(const MeshIndex& index, const Vec3& p, std::span<NearTriangle> batch,
                   FunctionRef<Flow(TriangleId, double)> visitor,
                   double radius = std::numeric_limits<double>::infinity()) noexcept;

/// All vertices, edges and faces that are within the radius of p as closed sets: an edge whose end
/// point is near counts, and so does a face whose side is. Each once, by kind and id, with its
/// squared distance. Vertices without a triangle are no features. Where they do not fit, some of
/// them. None where p is not finite, or the radius NaN or below 0. Thread safe.
[[nodiscard]] Neighbourhood collect_features(const MeshIndex& index, const Vec3& p, double radius,
                                             std::span<NearestFeature> buffer) noexcept;

} // namespace proxima
