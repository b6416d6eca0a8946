// Culling without a tree, by vector lanes: what a tree must beat. In floats, without error bounds.
//
//     triangles   nine arrays of coordinates, a lane per triangle; a block is left once none of its
//                 triangles is inside of all planes asked so far
//     vertices    a byte of planes per vertex, computed once; then three bytes per triangle
#pragma once

#include "proxima/cull.h"
#include "proxima/view_volume.h"

#include <array>
#include <cstdint>
#include <hwy/aligned_allocator.h>
#include <span>
#include <vector>

namespace proxima::bench {

/// A plane in floats.
struct LanePlane {
    std::array<float, 4> numbers;
};

/// The volume in floats. \pre at most 8 planes
[[nodiscard]] std::vector<LanePlane> lane_planes(const ViewVolume& volume);

/// Lanes of triangles, in the order given.
class TriangleArrays {
public:
    explicit TriangleArrays(std::span<const Triangle> triangles);

    /// Writes the ids (places in the order) of those visible; room for all of them and 16 more.
    [[nodiscard]] std::size_t visible_ids(std::span<const LanePlane> planes,
                                          std::span<std::uint32_t> ids) const;
    /// Ranges of places; room for half as many as triangles.
    [[nodiscard]] std::size_t visible_ranges(std::span<const LanePlane> planes,
                                             std::span<TriangleRange> ranges) const;

private:
    std::size_t count_;
    std::size_t padded_; ///< to whole blocks
    std::array<hwy::AlignedFreeUniquePtr<float[]>, 9> coordinates_;
};

/// Vertices once, triangles by their corners.
class VertexArrays {
public:
    VertexArrays(std::span<const Vec3> positions, std::span<const TriangleCorners> triangles);

    /// As TriangleArrays::visible_ids.
    [[nodiscard]] std::size_t visible_ids(std::span<const LanePlane> planes,
                                          std::span<std::uint32_t> ids);
    [[nodiscard]] std::size_t visible_ranges(std::span<const LanePlane> planes,
                                             std::span<TriangleRange> ranges);

private:
    void find_outside(std::span<const LanePlane> planes);

    std::size_t vertices_;
    std::array<hwy::AlignedFreeUniquePtr<float[]>, 3> coordinates_;
    std::vector<std::uint8_t> outside_; ///< by vertex, bits by plane
    std::vector<TriangleCorners> triangles_;
};

} // namespace proxima::bench
