// How long the children of a block are sure to stay apart from a block of the other mesh, eight at a time.
#pragma once

#include "index/index_parts.h"
#include "query/contacts/motion_bounds.h"

#include <array>
#include <cstddef>

namespace proxima {

/// A block of A and one of B at a time, of which one is opened, or none: then they stand in slot 0.
struct OpenedBlocks {
    const MovedFrame& frame;
    const BoundedBlock& a;
    const BoundedBlock& b;
    const IndexNode* node; ///< whose children are looked at; null for none
    bool opens_a;          ///< the node is A's
    Vec3 hint;             ///< a direction to be tried first, or zero
    double within;         ///< what stays apart this long may count as apart for ever
    double enough; ///< what stays apart this long needs no further direction; at most `within`
};

/// By slot. Directions are of length 1, from A to B, or zero where the step is 0.
struct ChildSteps {
    alignas(64) std::array<double, 8> step; ///< negative where there is no child
    alignas(64) std::array<std::array<double, 8>, 3> direction;
    alignas(64) std::array<double, 8> apart; ///< the centers, squared
    std::array<BlockBox, 8> box;             ///< of the node's children

    [[nodiscard]] Vec3 direction_of(std::size_t slot) const
    {
        return {direction[0][slot], direction[1][slot], direction[2][slot]};
    }
};

/// The longest steps along several directions: the hint, between the centers, across both slabs, the axes of both
/// meshes. Noexcept, no allocation; the same bits on every instruction set.
void find_child_steps(const MotionBounds& bounds, const OpenedBlocks& opened,
                      ChildSteps& steps) noexcept;

} // namespace proxima
