// What distances between meshes are found with: a mesh index, and round each of its blocks a slab.
//
//     \  upper  \          lower <= n . (p - c) <= upper for all points p of the block's triangles,
//     c
//      \ .-'--. .\         the center of its box, n across its patch of surface: what boxes askew
//      to
//       \'  lower `\       it waste, slabs save
//
// Slabs are in the order of the blocks, so that those of a node's children lie side by side.
#pragma once

#include "index/mesh_index.h"

#include <cstdint>
#include <memory>
#include <span>

namespace proxima {

/// A slab in eight bytes. With e the reach of the box along n, the sum of |n_k| half_k:
struct BlockSlab {
    std::uint32_t normal = 0; ///< x, y, z from the top in ten bits each, signed, times 2^-9
    std::uint32_t extent =
        0; ///< upper, lower from the top in sixteen bits each, signed, times e 2^-15
};

/// Immutable; copies share the storage. Thread safe. Made by build_distance_index.
class DistanceIndex {
public:
    [[nodiscard]] const MeshIndex& triangles() const noexcept { return triangles_; }

    /// Of every block, and seven more to be read along. Those of no triangles are zero.
    [[nodiscard]] std::span<const BlockSlab> slabs() const noexcept { return slabs_; }

    /// Bytes of slabs and of the mesh index.
    [[nodiscard]] std::uint64_t bytes() const noexcept
    {
        return triangles_.bytes() + slabs_.size_bytes();
    }

private:
    friend class DistanceIndexWriter;

    MeshIndex triangles_;
    std::span<const BlockSlab> slabs_;
    std::shared_ptr<const void> storage_;
};

} // namespace proxima
