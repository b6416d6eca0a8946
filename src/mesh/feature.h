// The features of a mesh that can be closest to a point: its vertices, edges and faces.
#pragma once

#include <compare>
#include <cstdint>

namespace proxima {

/// Ordered by dimension.
enum class FeatureKind : std::uint8_t { vertex, edge, face };

/// One feature: a VertexId, an EdgeId of the topology, or a TriangleId as a plain number.
struct Feature {
    FeatureKind kind = FeatureKind::vertex;
    std::uint32_t id = 0;

    friend constexpr bool operator==(const Feature&, const Feature&) = default;
    /// By kind (vertex < edge < face), then id: the order that settles ties.
    // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 sees a null where comparisons are made
    friend constexpr std::strong_ordering operator<=>(const Feature&, const Feature&) = default;
};

} // namespace proxima
