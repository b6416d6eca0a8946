// Hits of rays with the triangles of a mesh (thesis section 5.3): the closest, any, or all.
//
//     auto index = build_mesh_index(mesh);
//     if (auto hit = closest_hit(*index, {.origin = eye, .direction = view})) shade(*hit);
//
// Answers are those of brute_force.h, bit for bit: floats only sort out what cannot be hit. No ray
// slips through between triangles that share an edge or a corner. Coordinates may have any scale
// and lie anywhere. An invalid ray (ray.h) hits nothing.
#pragma once

#include "base/parallel.h"
#include "base/progress.h"
#include "base/result.h"
#include "index/mesh_index.h"
#include "query/rays/ray_hit.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

namespace proxima {

/// The first hit. Real-time safe: noexcept, no allocation, no lock; any number of threads.
/// 0.05 to 0.5 us on scanned models; rays from beyond 2^40 times the mesh's size cost 10 ns per
/// triangle.
[[nodiscard]] std::optional<RayHit> closest_hit(const MeshIndex& index, const Ray& ray,
                                                Faces faces = Faces::both) noexcept;

/// Whether there is a hit. As closest_hit, and quicker.
[[nodiscard]] bool any_hit(const MeshIndex& index, const Ray& ray,
                           Faces faces = Faces::both) noexcept;

/// All hits in order: the first hits.size() of them are written there. Returns how many there are.
/// As closest_hit, plus the logarithm of hits.size() for every hit.
[[nodiscard]] std::size_t all_hits(const MeshIndex& index, const Ray& ray, std::span<RayHit> hits,
                                   Faces faces = Faces::both) noexcept;

/// The same as a list. Allocates it.
[[nodiscard]] std::vector<RayHit> all_hits(const MeshIndex& index, const Ray& ray,
                                           Faces faces = Faces::both);

namespace detail {
using VisitHit = void (*)(void* context, const RayHit& hit) noexcept;
void visit_hits(const MeshIndex& index, const Ray& ray, Faces faces, VisitHit visit,
                void* context) noexcept;
} // namespace detail

/// Calls visitor(const RayHit&) for every hit, each triangle once, in no particular order. As
/// closest_hit; the visitor must not throw.
template <class Visitor>
void visit_hits(const MeshIndex& index, const Ray& ray, Faces faces, Visitor&& visitor) noexcept
{
    using Callable = std::remove_reference_t<Visitor>;
    detail::visit_hits(
        index, ray, faces,
        [](void* context, const RayHit& hit) noexcept { (*static_cast<Callable*>(context))(hit); },
        const_cast<void*>(static_cast<const void*>(&visitor)));
}

struct RayBatchOptions {
    Faces faces = Faces::both;
    Threads threads = {1};
    Progress* progress = nullptr; ///< stage "casting rays", steps are rays
};

/// The same for many rays, several at a time, so that their memory accesses overlap. Of sixteen in
/// a row that begin and go much the same way, as a camera's do, the closest or any hits are
/// searched together, which pays where triangles are larger than the rays' spacing: keep such rays
/// together. Answers are those of single rays. Allocates. Errors: invalid_argument (sizes differ,
/// or a ray is invalid: which and why), cancelled.
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
