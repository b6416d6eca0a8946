// The cells of an octree along a ray, in order, with what each weighs (thesis section 5.3).
//
//     for (const CellOnRay& at : cells_along_ray(*octree, ray)) density += at.chord;
//
//     enter   exit = enter   exit = enter   exit
//       |--- cell ---|--- cell ---|--- cell ---|        stretches of the ray join without a gap
//
// The chord is the length of the ray within a cell. The penetration is the thesis's: cell and ray
// sum to an endless prism along the ray; how far the ray is from the prism's sides, over the most
// that this can be, is 1 through the middle of the cell and 0 along its border.
#pragma once

#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/octree.h"

#include <vector>

namespace PROXIMA_EXPORT proxima {

/// A leaf, empty or not, and the stretch of the ray in it.
struct CellOnRay {
    Cell cell;
    double enter = 0;       ///< t, as rounded
    double exit = 0;        ///< t; the next cell's enter, the same bits
    double chord = 0;       ///< (exit - enter) |direction|, in the mesh's unit
    double penetration = 0; ///< 0 to 1
};

/// Visits every leaf in which the ray has a stretch, in order, until the visitor returns Flow::stop;
/// it must not throw. Which leaves, and in which order, is decided exactly. Leaves touched only in a
/// point are left out; a ray within a face between cells counts as in the upper ones, except on the
/// root's own upper faces. Nothing for an invalid ray. Chords add up to that of the root. About 30 ns
/// a cell. Thread safe, no allocation.
/// \pre differences of the ray's and the root's coordinates are finite
void cells_along_ray(const Octree& octree, const Ray& ray,
                     FunctionRef<Flow(const CellOnRay&)> visitor) noexcept;

/// All cells along the ray in order, in a vector that it allocates.
[[nodiscard]] std::vector<CellOnRay> cells_along_ray(const Octree& octree, const Ray& ray);

/// The thesis's weight of a box for the line of a ray: min_k rho_k / min_k rho_k at the centre,
/// with n_k = e_k x d, rho_k = (|n_k| . half - |n_k . (centre - o)|) / ||n_k||; 0 where the line
/// misses. \pre is_valid(ray), the box is not empty
[[nodiscard]] double penetration(const Box& box, const Ray& ray) noexcept;

} // namespace proxima
