// Labels cells with features, level by level: which touch them, which they are closest to
// (thesis 4.3.1).
//
// A feature that misses a cell misses its children, so that only the parent's lists are asked.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "thesis/proximity_octree/feature_numbers.h"
#include "thesis/proximity_octree/grown_regions.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace proxima {

/// One list of feature numbers per cell, ascending.
struct CellLists {
    std::vector<std::size_t> first = {0};
    std::vector<std::uint32_t> numbers;

    [[nodiscard]] std::span<const std::uint32_t> list(std::size_t cell) const noexcept
    {
        return std::span(numbers).subspan(first[cell], first[cell + 1] - first[cell]);
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return first.size() * sizeof(std::size_t) + numbers.size() * sizeof(std::uint32_t);
    }
};

/// The part of an ascending list that is of one kind.
[[nodiscard]] inline std::span<const std::uint32_t>
of_kind(std::span<const std::uint32_t> list, const FeatureNumbers& numbers, FeatureKind kind)
{
    const auto from = std::ranges::lower_bound(list, numbers.first(kind));
    const auto to = std::ranges::lower_bound(list, numbers.end(kind));
    return {from, to};
}

/// Cells of one depth. Features that touch a cell are in both of its lists.
struct LabelledCells {
    std::vector<CellKey> keys;
    std::vector<CellClass> types;
    CellLists closest;  ///< empty for inner cells
    CellLists touching; ///< empty for all but boundary cells

    [[nodiscard]] std::size_t size() const noexcept { return keys.size(); }
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return keys.size() * (sizeof(CellKey) + sizeof(CellClass)) + closest.bytes() +
               touching.bytes();
    }
};

struct LabelOptions {
    std::uint64_t held_bytes = 0; ///< already in use, of the budget
    Execution execution = {};
};

/// Labels the cells of one root. Keeps references to what it is given. Thread safe.
class CellLabeller {
public:
    CellLabeller(const TriangleMesh& mesh, const Topology& topology, const GrownRegions& regions,
                 OctreeFrame frame) noexcept
        : mesh_(mesh), topology_(topology), numbers_(topology), regions_(regions),
          frame_(std::move(frame))
    {}

    /// The root: all features that have a region touch it.
    [[nodiscard]] LabelledCells root() const;

    /// The children of these cells of a level, eight each, in order. The same for any number of
    /// threads. Errors: budget_exceeded, cancelled.
    [[nodiscard]] Result<LabelledCells> children(const LabelledCells& level,
                                                 std::span<const std::uint32_t> cells,
                                                 const LabelOptions& options) const;

private:
    void append_child(const LabelledCells& level, std::uint32_t cell, int octant,
                      LabelledCells& output) const;
    void append_touching(std::span<const std::uint32_t> candidates, const Box& box,
                         std::vector<std::uint32_t>& output) const;
    [[nodiscard]] bool touches(Feature feature, const Box& box) const;
    [[nodiscard]] bool is_before_a_face_of(std::span<const std::uint32_t> list,
                                           const Vec3& point) const;

    const TriangleMesh& mesh_;
    const Topology& topology_;
    FeatureNumbers numbers_;
    const GrownRegions& regions_;
    OctreeFrame frame_;
};

} // namespace proxima
