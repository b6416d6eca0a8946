// All triangles, one after the other, in double: the floor of what a search must beat, and what
// every answer is held against.
#pragma once

#include "proximity_peers.h"
#include "triangle_distance.h"

#include <vector>

namespace proxima::bench {

class BruteForcePeer {
public:
    explicit BruteForcePeer(const TriangleMesh& mesh) : triangles_(mesh, all_of(mesh)) {}

    [[nodiscard]] PeerAnswer closest(const Vec3& point) const
    {
        PeerAnswer best;
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            const double squared = triangles_.squared_distance(i, point);
            if (squared < best.squared_distance)
                best = {squared, TriangleId{static_cast<std::uint32_t>(i)}};
        }
        return best;
    }

    [[nodiscard]] std::size_t bytes() const { return triangles_.bytes(); }

private:
    static std::vector<TriangleId> all_of(const TriangleMesh& mesh)
    {
        std::vector<TriangleId> ids;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) ids.push_back(TriangleId{i});
        return ids;
    }

    ExactTriangles triangles_;
};

} // namespace proxima::bench
