// Built-in meshes by name, for tests, demos and measurements without files.
//
//     auto mesh = sample_mesh("sphere:100x100");   // 19,800 triangles, the sphere of thesis 2.1
//     const TriangleMesh ship = *make_spaceship(33000);
//
// Every one is closed and consistently oriented, counter-clockwise seen from outside, without
// degenerate triangles, and has the same bits on every machine.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <string_view>

namespace PROXIMA_EXPORT proxima {

/// No sample has more triangles.
inline constexpr std::size_t max_sample_triangles = std::size_t{1} << 27U;

/// True where `name` means a sample mesh and not a file: a known word, alone or before a colon
/// ("cube", "sphere:100x100"). Its size may still be wrong: sample_mesh says so.
[[nodiscard]] bool is_sample_mesh_name(std::string_view name) noexcept;

/// What names there are, for help texts: "sphere:STACKSxSLICES, icosphere:N, ...".
[[nodiscard]] std::string_view sample_mesh_names() noexcept;

struct SampleOptions {
    Execution execution = {}; ///< stage "making mesh", steps are triangles
};

/// The mesh of a name: `sphere:STACKSxSLICES`, `icosphere:N`, `cube`, `octahedron`, `torus:NxM`,
/// `spaceship:TRIANGLES`. Errors: invalid_argument (unknown name; a size out of its range, the
/// message gives the range), limit_exceeded (more than max_sample_triangles), budget_exceeded
/// (more memory than the machine can spare), all before anything is allocated; cancelled.
[[nodiscard]] Result<TriangleMesh> sample_mesh(std::string_view name,
                                               const SampleOptions& options = {});

/// Radius 1 around the origin, poles on z, vertex 0 at +z, then the rings from the top, each
/// starting on the +x side, last vertex at -z. The quads between two rings have their diagonal
/// from (ring i, slice j) to (i + 1, j + 1). 2 + (stacks - 1) slices vertices and 2 slices
/// (stacks - 1) triangles. Coordinates are multiples of 2^-40; mirror images are exact.
/// \pre stacks >= 2, slices >= 3
[[nodiscard]] TriangleMesh make_sphere(int stacks, int slices);

/// Icosahedron with corners at (0, +-1, +-golden ratio) and permutations, every triangle split in
/// four `subdivisions` times, all vertices moved to radius 1: 20 * 4^subdivisions triangles of
/// nearly the same size. \pre 0 <= subdivisions <= 11
[[nodiscard]] TriangleMesh make_icosphere(int subdivisions);

/// [-1, 1]^3, 8 vertices and 12 triangles.
[[nodiscard]] TriangleMesh make_cube();

/// Corners at distance 1 on the axes: +x, -x, +y, -y, +z, -z; 8 triangles.
[[nodiscard]] TriangleMesh make_octahedron();

/// Tube of radius 1/2 around the unit circle in the xy plane: `around` quads round the ring times
/// `across` round the tube, twice as many triangles. \pre around >= 3, across >= 3
[[nodiscard]] TriangleMesh make_torus(int around, int across);

/// A closed surface has an even number of triangles, so only even numbers have a ship.
inline constexpr std::size_t min_spaceship_triangles = 1300;

/// A procedural ship of exactly `triangles` triangles, about 4 long and 3 wide, nose towards +x,
/// top towards +z: hull, bridge, wings, cannons, engines and fins, with plates and boxes grown
/// on them, of very uneven triangle sizes. It stands in for the ship of thesis figure 3.16.
///
/// It consists of several closed components that reach into each other, as modelled ships do:
/// every edge has two triangles in opposite directions, and the inside is where the winding number
/// is at least 1. Errors: invalid_argument for fewer than min_spaceship_triangles or an odd
/// number (a closed surface has none), limit_exceeded for more than max_sample_triangles,
/// cancelled. O(triangles log triangles).
[[nodiscard]] Result<TriangleMesh> make_spaceship(std::size_t triangles,
                                                  const SampleOptions& options = {});

} // namespace proxima
