#include "octree/snapped_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/snapped_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After them: it is read once for every instruction set.
#include "octree/snapped_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

void find_cells_of_boxes(const SnappedArrays& mesh, std::size_t first, std::size_t count, int depth,
                         std::int32_t margin, std::uint32_t* lowest, std::uint32_t* highest)
{
    const IntTag di;
    const MaskTag dm;
    const auto zero = hn::Zero(di);
    const auto last = hn::Set(di, (1 << depth) - 1);
    const auto grown = hn::Set(di, margin);
    const int shift = snapped_bits - depth;
    for (std::size_t block = 0; block < count; block += hn::Lanes(di)) {
        Ints corner[3][3];
        for (std::size_t j = 0; j < 3; ++j) {
            // Lanes beyond the last triangle repeat it.
            load_points(
                [&](std::size_t lane) {
                    const std::size_t triangle = first + HWY_MIN(block + lane, count - 1);
                    return &mesh.vertices[mesh.corners[triangle][j]];
                },
                corner[j]);
        }
        auto low_cells = zero;
        auto high_cells = zero;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = corner[0][axis];
            const auto b = corner[1][axis];
            const auto c = corner[2][axis];
            const auto low = hn::Sub(hn::Min(hn::Min(a, b), c), grown);
            const auto high = hn::Add(hn::Max(hn::Max(a, b), c), grown);
            const auto low_cell = hn::Max(zero, hn::ShiftRightSame(low, shift));
            const auto high_cell = hn::Min(last, hn::ShiftRightSame(high, shift));
            low_cells = hn::Or(low_cells, hn::ShiftLeftSame(hn::Min(low_cell, last), 8 * axis));
            high_cells = hn::Or(high_cells, hn::ShiftLeftSame(high_cell, 8 * axis));
        }
        hn::StoreU(hn::BitCast(dm, low_cells), dm, lowest + block);
        hn::StoreU(hn::BitCast(dm, high_cells), dm, highest + block);
    }
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace proxima {

HWY_EXPORT(find_cells_of_boxes);

void find_cells_of_boxes(const SnappedArrays& mesh, std::size_t first, std::size_t count, int depth,
                         std::int32_t margin, std::uint32_t* lowest, std::uint32_t* highest)
{
    HWY_DYNAMIC_DISPATCH(find_cells_of_boxes)(mesh, first, count, depth, margin, lowest, highest);
}

} // namespace proxima

#endif
