// Builds an octree whose lists a function of the caller's finds: the hook for other overlap tests.
#pragma once

#include "octree/grow_subtree.h"
#include "proxima/octree.h"

#include <functional>

namespace proxima {

/// How the nodes and lists of an octree are found, and what the octree records about it.
struct ListFinder {
    OverlapMethod method = OverlapMethod::fast;
    bool is_exact = false; ///< lists hold exactly the triangles that touch
    /// Called once, with a checked mesh whose vertices lie in the frame.
    std::function<Result<OctreeOutput>(const TriangleMesh&, const OctreeFrame&,
                                       const OctreeOptions&, GrowLimits&)>
        find;
};

/// Like build_octree, with the finder's lists. Errors also those of the finder.
[[nodiscard]] Result<Octree>
build_octree_with(const TriangleMesh& mesh, const OctreeOptions& options, const ListFinder& finder);

} // namespace proxima
