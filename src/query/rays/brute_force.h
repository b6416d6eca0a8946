// The slow ray caster that the fast ones are held to: every triangle is asked.
#pragma once

#include "proxima/cast_ray.h"

#include <optional>
#include <vector>

namespace proxima {

/// The first hit; none for an invalid ray. O(triangles), 10 ns each; no allocation, thread safe.
/// \pre positions in use are finite
[[nodiscard]] std::optional<RayHit> closest_hit_by_brute_force(const TriangleMesh& mesh,
                                                               const Ray& ray,
                                                               Faces faces = Faces::both) noexcept;

/// Whether there is a hit. As the above.
[[nodiscard]] bool any_hit_by_brute_force(const TriangleMesh& mesh, const Ray& ray,
                                          Faces faces = Faces::both) noexcept;

/// All hits in order. As the above, but allocates the answer.
[[nodiscard]] std::vector<RayHit> all_hits_by_brute_force(const TriangleMesh& mesh, const Ray& ray,
                                                          Faces faces = Faces::both);

} // namespace proxima
