// What may be closest to a point of a block of a grid, eight side by side: leaves of the index, and in
// smaller blocks their triangles.
#pragma once

#include "index/index_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace proxima {

/// Boxes of leaves in the index's frame, eight side by side, and the references to these.
class LeafBoxes {
public:
    /// Eight boxes: by axis their lower planes and their upper ones.
    struct alignas(32) Group {
        std::array<std::array<float, 8>, 3> lower;
        std::array<std::array<float, 8>, 3> upper;
        std::array<std::uint32_t, 8> leaves;
        std::uint32_t count;
    };

    [[nodiscard]] std::span<const Group> groups() const noexcept { return groups_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }

    void clear() noexcept
    {
        groups_.clear();
        size_ = 0;
    }

    /// Adds a leaf. Its box is about its vertices, and larger by more than floats round.
    void add(const IndexLeaf& leaf, std::uint32_t position)
    {
        constexpr float rounding = 0x1p-20F;
        Group& group = group_for_one_more();
        const std::size_t lane = group.count++;
        ++size_;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            float least = std::numeric_limits<float>::infinity();
            float most = -least;
            for (const auto& corners : leaf.corners) {
                for (std::size_t i = 0; i < leaf.count; ++i) {
                    least = std::min(least, leaf.coordinates[axis][corners[i]]);
                    most = std::max(most, leaf.coordinates[axis][corners[i]]);
                }
            }
            group.lower[axis][lane] = least - rounding;
            group.upper[axis][lane] = most + rounding;
        }
        group.leaves[lane] = position;
    }

    /// Adds a box of another list.
    void add(const Group& from, std::size_t at)
    {
        Group& group = group_for_one_more();
        const std::size_t lane = group.count++;
        ++size_;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            group.lower[axis][lane] = from.lower[axis][at];
            group.upper[axis][lane] = from.upper[axis][at];
        }
        group.leaves[lane] = from.leaves[at];
    }

private:
    Group& group_for_one_more()
    {
        if (size_ % 8 == 0) {
            constexpr float none = std::numeric_limits<float>::infinity();
            groups_.emplace_back();
            groups_.back().count = 0;
            for (auto& lower : groups_.back().lower) lower.fill(none);
            for (auto& upper : groups_.back().upper) upper.fill(-none);
        }
        return groups_.back();
    }

    std::vector<Group> groups_;
    std::size_t size_ = 0;
};

/// Triangles in the index's frame, eight side by side, and their rows.
class TriangleLanes {
public:
    /// Lanes without a triangle have the first one's corners.
    struct alignas(32) Group {
        std::array<std::array<std::array<float, 8>, 3>, 3> corners; ///< by corner, then axis
        std::array<std::uint32_t, 8> rows;
        std::uint32_t count;
        float extent; ///< the largest of the leaves that they are from
    };

    [[nodiscard]] std::span<const Group> groups() const noexcept { return groups_; }
    [[nodiscard]] std::size_t size() const noexcept
    {
        return groups_.empty() ? 0 : 8 * (groups_.size() - 1) + groups_.back().count;
    }

    void clear() noexcept { groups_.clear(); }

    /// The triangles with a bit in `lanes`, of eight whose corners are `corners[k][axis][lane]`.
    template <class RowOf>
    void add(const float (&corners)[3][3][8], std::uint32_t lanes, float extent,
             const RowOf& row_of)
    {
        for (; lanes != 0; lanes &= lanes - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
            const bool opens = groups_.empty() || groups_.back().count == 8;
            if (opens) groups_.push_back({.corners = {}, .rows = {}, .count = 0, .extent = 0});
            Group& group = groups_.back();
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const float at = corners[k][axis][lane];
                    if (opens) {
                        group.corners[k][axis].fill(at);
                    } else {
                        group.corners[k][axis][group.count] = at;
                    }
                }
            }
            group.rows[group.count++] = row_of(lane);
            group.extent = std::max(group.extent, extent);
        }
    }

private:
    std::vector<Group> groups_;
};

} // namespace proxima
