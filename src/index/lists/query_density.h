// Where queries are expected: half of them anywhere in the box 1.2 times the mesh's, half of them
// within 2 % of the diagonal of the surface.
#pragma once

#include "index/lists/root_frame.h"
#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace proxima {

/// A cell's share of the expected queries.
struct CellDensity {
    double surface = 1;      ///< part of the queries near the surface
    std::uint32_t first = 0; ///< its sample points
    std::uint32_t last = 0;
};

/// Samples of the surface, sorted along the Morton curve of the root.
class QueryDensity {
public:
    /// Four points per triangle on average, spread by area: the same for the same mesh. Null where
    /// cancelled. 8 bytes per point.
    [[nodiscard]] static std::optional<QueryDensity>
    sample(const TriangleMesh& mesh, const Box& bounds, const RootFrame& frame, Progress* progress);

    [[nodiscard]] CellDensity root() const noexcept
    {
        return {1.0, 0, static_cast<std::uint32_t>(keys_.size())};
    }

    /// The children of a cell. \pre depth(key) < max_depth
    [[nodiscard]] std::array<CellDensity, 8> split(const CellDensity& cell, CellKey key) const;

    /// Probability that a query falls into the cell.
    [[nodiscard]] double probability(const CellDensity& cell, CellKey key) const;

    /// Cells may not be deeper.
    static constexpr int max_depth = 16;

private:
    std::vector<std::uint64_t> keys_; ///< cell keys at max_depth, ascending
    Vec3 box_half_ = Vec3::Ones();    ///< of the 1.2 times enlarged box, in the frame
    double frame_half_ = 1;
};

} // namespace proxima
