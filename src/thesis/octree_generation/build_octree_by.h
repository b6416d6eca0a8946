// Builds octrees with the overlap tests of the thesis (2.1, 3.4 to 3.7).
//
//     auto octree = build_octree_by(mesh, {.method = OverlapMethod::index_tracking}, {.max_depth = 5});
#pragma once

#include "proxima/octree.h"

namespace proxima {

/// Whether the thesis's methods may err by rounding. OverlapMethod::fast never does.
enum class Exactness : std::uint8_t {
    rounded, ///< as the arithmetic of doubles has it
    exact    ///< exactly the triangles that touch the closed cell, whatever the method
};

/// An overlap test, and how far it is trusted.
struct OverlapChoice {
    OverlapMethod method = OverlapMethod::fast;
    Exactness exactness = Exactness::rounded;
};

/// Like build_octree, with the lists that the chosen test finds. Errors and determinism as
/// build_octree; the thesis's tests take 10 to 10,000 times as long as OverlapMethod::fast
/// (`proxima compare` measures them).
[[nodiscard]] Result<Octree> build_octree_by(const TriangleMesh& mesh, const OverlapChoice& choice,
                                             const OctreeOptions& options = {});

/// The heuristic of thesis 2.1.1: builds with the given threshold, then again with the largest
/// number of triangles found in a leaf, which saves cells without longer worst lists.
/// The second octree's parameters().threshold is that number. Errors as build_octree.
[[nodiscard]] Result<Octree> build_octree_two_pass(const TriangleMesh& mesh,
                                                   const OverlapChoice& choice = {},
                                                   const OctreeOptions& options = {});

} // namespace proxima
