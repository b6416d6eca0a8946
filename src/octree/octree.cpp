#include "proxima/octree.h"

#include <utility>

namespace proxima {

Octree Octree::adopt(const OctreeFrame& frame, const OctreeParameters& parameters,
                     std::uint64_t triangle_count, std::span<const OctreeNode> nodes,
                     std::span<const TriangleId> references,
                     std::shared_ptr<const void> storage) noexcept
{
    Octree octree;
    octree.frame_ = frame;
    octree.parameters_ = parameters;
    octree.triangle_count_ = triangle_count;
    octree.nodes_ = nodes;
    octree.references_ = references;
    octree.storage_ = std::move(storage);
    return octree;
}

} // namespace proxima
