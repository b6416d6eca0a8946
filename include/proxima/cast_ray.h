// Hits of rays with the triangles of a mesh (thesis section 5.3): the closest, any, or all.
//
//     auto index = build_mesh_index(mesh);
//     if (auto hit = closest_hit(*index, {.origin = eye, .direction = view})) shade(*hit);
//
//     std::vector<std::optional<RayHit>> hits(rays.size());        // many rays, on all cores
//     Status done = closest_hits(*index, rays, hits);
//
//     hit     the first point of a closed triangle on the ray: one per triangle
//     order   by t as computed in doubles, then by triangle id
//
// Floats only sort out what cannot be hit; every answer is that of testing all triangles in doubles,
// bit for bit. No ray passes between triangles that share an edge or a corner. Coordinates may have
// any scale and lie anywhere. An invalid ray (is_valid) hits nothing.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// A point of a triangle on a ray: P = (1 - u - v) v0 + u v1 + v v2 = origin + t direction.
struct RayHit {
    double t = 0; ///< rounded, its sign exact: 0 just where the ray begins on the triangle
    TriangleId triangle{};
    double u = 0;
    double v = 0;
    friend bool operator==(const RayHit&, const RayHit&) = default;

    /// Whether it comes before another hit of its ray.
    [[nodiscard]] bool before(const RayHit& other) const noexcept
    {
        return t < other.t || (t == other.t && triangle < other.triangle);
    }
};

/// The first hit. Real-time safe: noexcept, no allocation, no lock; any number of threads.
/// 0.05 to 0.5 us on scanned models; rays from beyond 2^80 times the mesh's size are asked of every
/// triangle, for up to 5 us each, beyond 2^300 times up to 120 us.
[[nodiscard]] std::optional<RayHit> closest_hit(const MeshIndex& index, const Ray& ray,
                                                Faces faces = Faces::both) noexcept;

/// Whether there is a hit. As closest_hit, and quicker.
[[nodiscard]] bool any_hit(const MeshIndex& index, const Ray& ray,
                           Faces faces = Faces::both) noexcept;

/// All hits in order: writes the first hits.size() of them, and returns how many there are in all.
/// As closest_hit, plus the logarithm of hits.size() for every hit.
[[nodiscard]] std::size_t all_hits(const MeshIndex& index, const Ray& ray, std::span<RayHit> hits,
                                   Faces faces = Faces::both) noexcept;

/// All hits in order, in a vector that it allocates.
[[nodiscard]] std::vector<RayHit> all_hits(const MeshIndex& index, const Ray& ray,
                                           Faces faces = Faces::both);

/// Calls visitor(hit) for every hit, each triangle once, in no particular order, until it returns
/// Flow::stop. As closest_hit; the visitor must not throw.
void visit_hits(const MeshIndex& index, const Ray& ray, Faces faces,
                FunctionRef<Flow(const RayHit&)> visitor) noexcept;

struct RayBatchOptions {
    Faces faces = Faces::both;
    Execution execution = {}; ///< stage "casting rays", steps are rays
};

/// The same for many rays, several at a time, so that their memory accesses overlap. Of sixteen in
/// a row that begin and point much alike, as a camera's do, the closest or any hits are
/// searched together, where they come to few triangles: keep such rays together. Answers are those
/// of single rays. Allocates. Errors: invalid_argument (sizes differ, or a ray is invalid: which is
/// the first, and why), cancelled; answers of other rays may have been written by then.
[[nodiscard]] Status closest_hits(const MeshIndex& index, std::span<const Ray> rays,
                                  std::span<std::optional<RayHit>> hits,
                                  const RayBatchOptions& options = {});
[[nodiscard]] Status any_hits(const MeshIndex& index, std::span<const Ray> rays,
                              std::span<bool> hits, const RayBatchOptions& options = {});

/// Hits of many rays: those of ray i are hits[first[i]] to hits[first[i + 1] - 1].
struct RayHitLists {
    std::vector<std::size_t> first;
    std::vector<RayHit> hits;
};
[[nodiscard]] Result<RayHitLists> all_hits(const MeshIndex& index, std::span<const Ray> rays,
                                           const RayBatchOptions& options = {});

} // namespace proxima
