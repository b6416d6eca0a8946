// The pieces that a surface comes apart into where it branches, and which way they face. Internal.
//
//     edge of one triangle      boundary of a piece
//     edge of two               both are of one piece, and one can be turned to match the other
//     edge of three or more     pieces meet here
#pragma once

#include "mesh/surface_parts.h"
#include "proxima/execution.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace proxima::detail {

/// The number of triangles that are in no piece.
inline constexpr std::uint32_t no_piece = ~std::uint32_t{0};

/// Proper triangles connected across edges of exactly two.
struct SurfacePiece {
    std::uint32_t first_triangle = 0; ///< the lowest
    std::uint32_t triangles = 0;
    std::uint32_t turned = 0;          ///< triangles turned over to match
    std::uint64_t unmatched_edges = 0; ///< edges of two triangles that run the same way
    bool closed = true; ///< at each edge as many of its triangles run one way as the other
};

struct SurfacePieces {
    std::vector<SurfacePiece> pieces;    ///< by first triangle
    std::vector<std::uint32_t> piece_of; ///< by triangle
    std::vector<std::uint8_t> turned;    ///< by triangle: 1 if it is to be turned over
};

/// Finds the pieces of the proper triangles of `takes_part`, which has all or none of those that
/// edges connect. With `orient` each is oriented breadth first from its first triangle and then as
/// a whole so that at most half of its triangles are turned: the first is not where as many are.
/// Linear, but for edges of many triangles, which are sorted. Nothing where `progress`, which may
/// be null, asks to stop.
[[nodiscard]] std::optional<SurfacePieces>
find_surface_pieces(const TriangleMesh& mesh, const Topology& topology,
                    std::span<const EdgeUse> uses, std::span<const std::uint8_t> takes_part,
                    bool orient, Progress* progress);

/// By piece, as turned, the sign of the signed volume: 0 where the piece is not closed or not finite,
/// or the volume may be rounding. Linear.
[[nodiscard]] std::vector<int> volume_signs_of(const TriangleMesh& mesh,
                                               const SurfacePieces& surface);

/// What encloses something.
struct ClosedSurfaces {
    std::vector<std::uint32_t> surface_of; ///< by triangle its surface, no_piece of those of none
    std::uint32_t count = 0;
};

/// Pieces with volume, by their numbers, and after them what is left of components without their
/// closed pieces, where that has an even number of triangles at each edge: as solids that have walls
/// in common, which come apart into pieces that are open. Linear.
[[nodiscard]] ClosedSurfaces closed_surfaces_of(const TriangleMesh& mesh, const Topology& topology,
                                                const SurfacePieces& pieces,
                                                std::span<const int> volume_signs);

} // namespace proxima::detail
