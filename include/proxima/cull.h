// What a camera sees: the triangles or the cells of an octree in a view volume (thesis section 5.4).
//
//     auto volume = make_perspective_volume({.eye = eye, .forward = view, .near = 0.1});
//     std::vector<TriangleRange> ranges(index->triangle_count() / 2 + 1);       // as many as can be
//     const std::size_t count = visible_ranges(*index, *volume, ranges);
//
// Ranges are of rows: MeshIndex::ids says which triangle has which row, and index buffers laid out in
// that order are drawn range by range. Whole subtrees whose box is inside or outside take a few
// comparisons. Occlusion is not tested. Nothing is kept from one query to the next.
#pragma once

#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"
#include "proxima/view_volume.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

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

/// Calls visitor(range) for the visible triangles, ascending, each range as long as can be, until it
/// returns Flow::stop. Real-time safe: noexcept, no allocation, no lock; any number of threads; the
/// visitor must not throw. About 20 ns for every box that a plane cuts.
void visit_visible(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                   FunctionRef<Flow(TriangleRange)> visitor) noexcept;

/// Like visit_visible, into a list of the caller: writes the first ranges.size() ranges, and returns
/// how many there are in all, at most triangle_count() / 2 + 1.
[[nodiscard]] std::size_t visible_ranges(const MeshIndex& index, const ViewVolume& volume,
                                         std::span<TriangleRange> ranges,
                                         CullMode mode = CullMode::conservative) noexcept;

/// The ids of the visible triangles, ascending, in place of what `ids` held. Allocates where that
/// is too small, a bit per triangle, and 8 bytes per visible range.
void visible_triangles(const MeshIndex& index, const ViewVolume& volume, CullMode mode,
                       std::vector<TriangleId>& ids);
[[nodiscard]] std::vector<TriangleId> visible_triangles(const MeshIndex& index,
                                                        const ViewVolume& volume,
                                                        CullMode mode = CullMode::conservative);

/// A leaf, empty or not.
struct VisibleCell {
    Cell cell;
    bool is_inside = false; ///< of all planes, wholly
};

/// Visits every visible leaf in Morton order: conservatively those that no single plane has on its
/// outside, exactly those whose closed box has a point in common with the volume. Both decided
/// exactly. The walk ends where the visitor returns Flow::stop; it must not throw. Planes
/// that contain a cell are not tested again for its descendants. About 20 ns a cell, 50 where planes
/// are tested, up to 5 us for undecided leaves in exact mode. Thread safe, no allocation.
void visible_cells(const Octree& octree, const ViewVolume& volume, CullMode mode,
                   FunctionRef<Flow(const VisibleCell&)> visitor) noexcept;

/// All visible cells in order, in a vector that it allocates.
[[nodiscard]] std::vector<VisibleCell> visible_cells(const Octree& octree, const ViewVolume& volume,
                                                     CullMode mode = CullMode::conservative);

} // namespace proxima
