// Two mesh indexes in a pose: what the vector code needs of them, in floats.
//
//     frame 0   (p - c_a) s            s the coarser of the two indexes' scales, a power of two:
//     frame 1   (q - c_b) s            both meshes are within [-1, 1], one of them filling it
//     frame 1 to frame 0               x = R y + o
//     frame 0 to frame 1               y = R^T x - R^T o
//
// p are the points of A as they are, q those of B before the pose moves them.
#pragma once

#include "index/index_parts.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"

#include <array>
#include <cstdint>
#include <span>

namespace proxima {

/// A box in the frame of its own mesh, and the block that it is drawn around.
struct alignas(32) PairBox {
    std::array<float, 3> center;
    std::array<float, 3> half;
    std::uint32_t reference;
    float size; ///< sum of `half`; of leaves leaf_size, so that the other one is opened
};
inline constexpr float leaf_size = -1;

// Bounds of the boxes' tests, u = 2^-24, in units of the frames: what is farther apart is apart.
//
// A block's box is drawn outward by 20 u of the index's units (block_boxes.cpp). Its centre c =
// (origin + 32768 step) + (lower + upper) (step / 2) is off by 1.01 u for the first sum, 2.1 u for
// the product and 1.01 u for the last sum, its half size by 1.1 u: what is below the block is in
// the box as computed. So take centres c, y and half sizes h, g of two boxes as they are, |y| <=
// 1.01 each, |o| <= 2.9, or 5.1 turned back. R y + o, each number: R and the products are off by u,
// the sum of three is at most 1.75, those with o at most 6.9: 2 * 1.75 u + 3 * 6.9 u + 5.1 u for
// o's own rounding < 30 u, and d = R y + o - c, at most 7.9, by 7.9 u more: 38 u. An axis is
// compared by |axis . d| - radii:
//     own face     38 u + radii, 1.75 (R, product) u + 3 sums below 2.8 u             <  60 u
//     its face     38 u sqrt(3) + |d|_2 <= 13.7 times 4 u + radii below 4 * 2.8 u     < 135 u
//     two edges    38 u sqrt(2) + 11.2 * 3 u + radii of four terms below 2.9, 5 u     < 105 u
// The columns of R are orthogonal to 1e-9 < 0.02 u, which moves radii and, where the way back is by
// R^T, points by less than 0.1 u. The pose's own rounding comes to |axis|_1 <= sqrt(3) times that
// of a number, sqrt(3) / 1.8 of pose_error in frame 1 as well. Twice that and 160 u are the slack.
//
// A leaf's slab, l <= n . (p - p_0) <= m with |n| = 1, is compared with boxes in the other's frame by
// n' . d + l and n' . d + m, n' = R n as computed and d from a box's centre to p_0:
//     n' . d         38 u sqrt(3) + |d|_2 <= 13.7 times 3 u                           < 107 u
//     l, m           |p - p_0|_2 <= 3.5: points 3 u sqrt(3), 3 u of 3.5               <  16 u
//     n' for R n     4 u a number, 7 u of 3.5                                         <  25 u
//     radii 4 u of 1.75, the sum n' . d + l 17.2 u                                    <  25 u
// Below 173 u, and |n'|_2 <= 1.01 times the pose's error as above: twice the slack. It suffices for
// vertices of a leaf in place of boxes: u / 2 a number for having been stored, but no radii.

/// From the other's frame to the own one, R and o, as vectors of eight: what a box there adds to
/// the radii of the fifteen axes is a sum of these times its numbers (box_pairs-inl.h).
struct alignas(32) PairFrame {
    std::array<std::array<float, 8>, 3> columns; ///< by j: R_ij for i = 0 to 2, 0, |R_ij|, 0
    std::array<float, 8> offset;                 ///< o, 0, slack four times
    /// |R_ij| once more, as edges need it; the first two make axes e_i x R_0, then e_i x R_1, the
    /// others e_i x R_2, then faces R_j.
    std::array<std::array<float, 8>, 4> edges;
    float slack;                                        ///< of every axis, see above
    std::array<std::array<double, 4>, 3> exact_columns; ///< of R, and 0
    std::array<double, 4> exact_offset;                 ///< o, 0
};

struct PairSide {
    const IndexParts* index = nullptr;
    const IndexBlock* blocks = nullptr;
    float unit = 1; ///< of the index's blocks, a power of two, at most 1
};

struct ContactSearch {
    std::array<PairFrame, 2> frames; ///< [0]: from 1 to 0
    std::array<PairSide, 2> sides;
    const RigidTransform* pose = nullptr;
    /// In units of the frames, how far coordinates may be off beside floats: by rounding of moved
    /// points and of the offset, and of coordinates that were put into the indexes' units.
    float pose_error = 0;

    /// Every descent replaces a block by one of its children, in one of the meshes: of at most
    /// that many levels, each leaving seven others to be looked at.
    static constexpr std::size_t stack_size = 7 * (2 * IndexParts::max_levels - 2) + 1;
};

/// What contact_search says.
enum class PairStart : std::uint8_t {
    apart,   ///< nothing meets
    ready,   ///< to be walked
    too_far, ///< beyond what floats can sort out: every pair must be asked
};

/// Sets everything up. Indexes and pose must outlive `open`.
[[nodiscard]] PairStart contact_search(const IndexParts& a, const IndexParts& b,
                                       const RigidTransform& pose_b, ContactSearch& open) noexcept;

/// Whether two triangles meet, by their rows: A's as it is, B's with its corners moved. Exact for
/// these; false where a moved corner is not finite.
[[nodiscard]] bool ask_rows(const IndexParts& a, std::uint32_t row_a, const IndexParts& b,
                            std::uint32_t row_b, const RigidTransform& pose_b) noexcept;

[[nodiscard]] inline bool ask_rows(const ContactSearch& open, std::uint32_t row_a,
                                   std::uint32_t row_b) noexcept
{
    return ask_rows(*open.sides[0].index, row_a, *open.sides[1].index, row_b, *open.pose);
}

/// Rows of both indexes.
struct RowPair {
    std::uint32_t a;
    std::uint32_t b;
};

/// Takes pairs that meet, at most max_rows_together at a time; none where none was found for long.
using RowPairVisitor = FunctionRef<Flow(std::span<const RowPair>)>;
inline constexpr std::size_t max_rows_together = 256;

/// Like visit_intersecting_pairs, by rows.
void visit_intersecting_rows(const IndexParts& a, const IndexParts& b, const RigidTransform& pose_b,
                             RowPairVisitor visitor);

} // namespace proxima
