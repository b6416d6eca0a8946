// An octree whose arrays a test may break.
#pragma once

#include "proxima/octree.h"

#include <memory>
#include <vector>

namespace proxima::testing {

struct EditableOctree {
    OctreeFrame frame;
    OctreeParameters parameters;
    std::uint64_t triangle_count = 0;
    std::vector<OctreeNode> nodes;
    std::vector<TriangleId> references;

    explicit EditableOctree(const Octree& octree)
        : frame(octree.frame()), parameters(octree.parameters()),
          triangle_count(octree.triangle_count()),
          nodes(octree.nodes().begin(), octree.nodes().end()),
          references(octree.references().begin(), octree.references().end())
    {}

    /// An octree on copies of the arrays.
    [[nodiscard]] Octree octree() const
    {
        auto storage = std::make_shared<EditableOctree>(*this);
        return Octree::adopt(frame, parameters, triangle_count, storage->nodes, storage->references,
                             storage);
    }
};

} // namespace proxima::testing
