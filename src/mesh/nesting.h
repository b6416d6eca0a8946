// Which closed surfaces of a mesh lie inside others. Internal.
#pragma once

#include "proxima/execution.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A point of a closed surface, and the surface's number.
struct SurfaceSample {
    Vec3 position = Vec3::Zero();
    std::uint32_t surface = 0;
};

/// The number of triangles that belong to no surface.
inline constexpr std::uint32_t no_surface = ~std::uint32_t{0};

/// For every sample 1 if an odd number of the other surfaces has it inside, exactly: parity of
/// the triangles above it. A point on another surface counts as moved a hair along x, then y, then
/// z. `surface_of` numbers the closed surface of each triangle. Triangles times the samples below
/// their shadow along z, found by a tree. The same for any number of
/// threads. Early, with no answer, where `progress`, which may be null, asks to stop.
/// \pre triangles of surfaces and samples are finite
[[nodiscard]] std::vector<std::uint8_t> odd_nesting(const TriangleMesh& mesh,
                                                    std::span<const std::uint32_t> surface_of,
                                                    std::span<const SurfaceSample> samples,
                                                    Threads threads, const Progress* progress);

/// For every surface 1 if it lies in an odd number of others: if each of its corners does that it
/// shares with none of them, and there is such a corner. So what passes through another surface is
/// not inside. Corners are looked at only where the surface's box is in another one's, which makes
/// this near-linear but for surfaces far above each other. Early as above. \pre surface_of is
/// no_surface or below `count`; triangles of surfaces are finite
[[nodiscard]] std::vector<std::uint8_t> nested_surfaces(const TriangleMesh& mesh,
                                                        std::span<const std::uint32_t> surface_of,
                                                        std::uint32_t count, Threads threads,
                                                        const Progress* progress);

} // namespace proxima
