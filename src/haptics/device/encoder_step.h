// The smallest change of position that a device can report, from positions that it has reported.
//
//     x_0  x_1  x_1  x_2 ...   ─▶  |differences| that are not 0  ─▶  multiples of one step?
//
// Encoders along the axes put all positions on a grid: then every difference is a multiple of the
// step, and the step is known to much less than a per cent. Those in the joints of an arm do not: then
// the difference that nine of ten do not exceed, in a slow motion, stands for the step.
#pragma once

#include <cstddef>
#include <span>

namespace proxima {

/// What the positions along an axis show.
enum class StepKind : unsigned char {
    unknown, ///< fewer than 20 changes of 1e-12 m at least
    grid,    ///< all changes are multiples of the step
    uneven, ///< positions repeat while the tip moves, but not on a grid: the step is what nine of ten changes do not exceed
    invisible ///< every sample of a slow motion differs: no step can be seen
};

struct EncoderStep {
    StepKind kind = StepKind::unknown;
    double step = 0;         ///< m; 0 where unknown or invisible
    double least_change = 0; ///< m, of all that count
    std::size_t changes = 0;
};

/// The step along an axis, from positions, m, of successive samples of a motion so slow that most
/// changes are one step or a few. On a grid it is right to a per mille if two in a hundred changes
/// are no multiples at all, and to a per cent if each position is also off by a twentieth of a
/// step. O(n log n), allocates.
[[nodiscard]] EncoderStep estimate_encoder_step(std::span<const double> positions);

} // namespace proxima
