// CGAL's AABB_tree as a peer, in double, with its tree of points for first guesses
// (accelerate_distance_queries).
#pragma once

#include "proximity_peers.h"

#include <memory>

namespace proxima::bench {

/// Leaves triangles without area out, which CGAL does not take. Made for one thread.
class CgalPeer {
public:
    explicit CgalPeer(const TriangleMesh& mesh);
    ~CgalPeer();
    CgalPeer(const CgalPeer&) = delete;
    CgalPeer& operator=(const CgalPeer&) = delete;

    [[nodiscard]] PeerAnswer closest(const Vec3& point);
    /// What the heap grew by while it was built.
    [[nodiscard]] std::size_t bytes() const;

private:
    struct Built;
    std::unique_ptr<Built> built_;
};

} // namespace proxima::bench
