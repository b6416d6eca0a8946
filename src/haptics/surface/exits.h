// Exits from closed meshes: for proxies that must not begin inside.
//
//      _____
//     |  p..|x      p inside, the nearest point of the surface, x a step beyond it
//     |_____|
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"

#include <optional>

namespace proxima {

/// The index with signs where these tell inside from outside everywhere, by the closest feature: of
/// a closed mesh that is oriented consistently and does not intersect itself. Else the index itself.
/// Errors and cost: those of with_signs, unless the index has signs.
[[nodiscard]] Result<MeshIndex> with_exits(const MeshIndex& index, const Execution& execution = {});

/// The point of the surface nearest to p where p is inside; nothing outside, and of an index that
/// does not tell its inside everywhere. noexcept, no allocation; the time of signed_distance.
/// \pre p is finite
[[nodiscard]] std::optional<Vec3> exit_of(const MeshIndex& index, const Vec3& p) noexcept;

/// The exit of p and a step of two gaps farther; p where it is at its exit.
[[nodiscard]] Vec3 beyond(const Vec3& exit, const Vec3& p, double gap) noexcept;

} // namespace proxima
