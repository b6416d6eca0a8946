// What distances between meshes are found with: a ray index, and round each of its blocks a slab.
//
//     \  upper  \          n . p between lower and upper for all points p of the block's triangles,
//      \ .-'--. .\         n across the block's patch of surface: what boxes askew to it waste,
//      slabs
//       \'  lower `\       save
//
// Numbers are arrays over blocks, so that a node's children, side by side, are read at once.
#pragma once

#include "proxima/query/ray_index.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace proxima {

/// Immutable; copies share the storage. Thread safe. Made by build_distance_index.
class DistanceIndex {
public:
    [[nodiscard]] const RayIndex& triangles() const noexcept { return triangles_; }

    /// A slab's five numbers, in units of the blocks.
    enum Number : std::size_t { normal_x, normal_y, normal_z, lower, upper };
    static constexpr std::size_t numbers = 5;
    /// Of every block, and of as many more as fill a register. Those of no triangles are zero.
    [[nodiscard]] std::span<const float> slabs(std::size_t number) const noexcept
    {
        return slabs_[number];
    }

    /// Bytes of slabs and of the ray index.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return triangles_.bytes() + numbers * slabs_[0].size_bytes();
    }

private:
    friend class DistanceIndexWriter;

    RayIndex triangles_;
    std::array<std::span<const float>, numbers> slabs_;
    std::shared_ptr<const void> storage_;
};

} // namespace proxima
