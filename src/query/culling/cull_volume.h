// Which triangles a camera sees: those in a view volume, whatever hides them (thesis section 5.4).
//
//     auto volume = make_perspective_volume({.eye = eye, .forward = view, .near = 0.1});
//     std::vector<TriangleRange> ranges(4096);
//     const std::size_t count = visible_ranges(*index, *volume, ranges);
//
// Ranges are of the index's order of triangles: MeshIndex::ids says which triangle stands where, and
// index buffers laid out like that are drawn range by range. Whole subtrees whose box is inside or
// outside are passed or dropped by a few comparisons. Nothing is dropped for lying behind another
// triangle.
//
// Nothing is kept from one query to the next: along smooth paths of a camera what was cut a frame
// ago spares less than keeping it costs, but where it all but stands still (docs/benchmarks.md,
// Culling).
#pragma once

#include "index/mesh_index.h"
#include "proxima/view_volume.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace proxima {

/// What counts as visible. Both answers are exact for the doubles of planes and positions.
enum class CullMode : std::uint8_t {
    conservative, ///< not wholly outside of any one plane: some triangles near edges lie outside
    exact         ///< has a point in common with the volume
};

/// Rows [first, first + count) of a mesh index.
struct TriangleRange {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    friend bool operator==(const TriangleRange&, const TriangleRange&) = default;
};

namespace detail {
using VisitRange = void (*)(void* context, TriangleRange range) noexcept;
void visit_visible(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                   VisitRange visit, void* context) noexcept;
} // namespace detail

/// Calls visitor(TriangleRange) for the visible triangles, ascending, each range as long as can be.
/// Real-time safe: noexcept, no allocation, no lock; any number of threads; the visitor must not
/// throw. About 20 ns for every box that a plane cuts.
template <class Visitor>
void visit_visible(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                   Visitor&& visitor) noexcept
{
    using Callable = std::remove_reference_t<Visitor>;
    detail::visit_visible(
        index, volume, mode,
        [](void* context, TriangleRange range) noexcept {
            (*static_cast<Callable*>(context))(range);
        },
        const_cast<void*>(static_cast<const void*>(&visitor)));
}

/// The same into a list of the caller: the first ranges.size() of them are written there. Returns
/// how many there are; triangle_count() / 2 + 1 places always suffice.
[[nodiscard]] std::size_t visible_ranges(const MeshIndex& index, const ViewVolume& volume,
                                         std::span<TriangleRange> ranges,
                                         CullMode mode = CullMode::conservative) noexcept;

/// The ids of the visible triangles, ascending, in place of what `ids` held. Allocates where that
/// is too small, and a bit per triangle.
void visible_triangles(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                       std::vector<TriangleId>& ids);
[[nodiscard]] std::vector<TriangleId> visible_triangles(const MeshIndex& index,
                                                        const ViewVolume& volume,
                                                        CullMode mode = CullMode::conservative);

} // namespace proxima
