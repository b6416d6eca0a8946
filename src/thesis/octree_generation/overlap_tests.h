// The thesis's four triangle-cell overlap tests, behind one interface (thesis 3.2-3.6).
#pragma once

#include "proxima/geometry.h"

#include <concepts>

namespace proxima {

/// What a test in rounded arithmetic says of a triangle and a closed cell.
struct Overlap {
    bool overlaps = false; ///< the rounded answer
    bool certain = false;  ///< rounding cannot have changed it
};

/// One triangle against many cells, level by level: constants of the triangle are found by the
/// constructor, those of a depth by set_half_size, so that overlap() does only what depends on the
/// cell's position. Cells of one depth are equal but for rounding of their planes, which `certain`
/// allows for: a certain answer is that for the cell's own closed box (rounding_bounds.h). For this
/// the first half size must be that of the root or of its children.
template <class T>
concept OverlapTest = requires(T test, const T constant, const Triangle& triangle,
                               const Vec3& vector)
{
    T(triangle);
    test.set_half_size(vector); // half the edges of the cells of the next depth, descending
    {
        constant.overlap(vector)
        } -> std::same_as<Overlap>; // centre of a cell
};

} // namespace proxima
