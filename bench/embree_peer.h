// Embree 3's point query as a peer: it walks its tree of boxes and calls us for every triangle it
// reaches; distances in float, the winner and its near ties again in double.
//
// What was found to be quickest, and used: a robust scene of user geometry, one triangle a
// primitive (half the calls of Embree's own triangles, whose leaves of four are not tested one by
// one), triangles in Morton order, and corners read from an array of our own.
#pragma once

#include "proximity_peers.h"

#include <array>
#include <cstdint>
#include <memory>

namespace proxima::bench {

/// How large the ball is that a search begins with.
enum class FirstRadius : std::uint8_t {
    infinite,
    /// The last distance plus how far the point moved since: a bound that always holds. Batches
    /// whose neighbours are apart are sorted along a Morton curve first, so that each point is
    /// near the last.
    warm
};

/// Made for one thread. Distances are right up to rounding in double.
class EmbreePeer {
public:
    EmbreePeer(const TriangleMesh& mesh, FirstRadius first);
    ~EmbreePeer();
    EmbreePeer(const EmbreePeer&) = delete;
    EmbreePeer& operator=(const EmbreePeer&) = delete;

    [[nodiscard]] PeerAnswer closest(const Vec3& point);
    [[nodiscard]] std::size_t bytes() const;
    /// Embree's tree; what the adapter tests in place of Embree's triangles; and what it adds for
    /// answers in doubles.
    [[nodiscard]] std::array<BytePart, 3> byte_parts() const;

private:
    struct Built;
    std::unique_ptr<Built> built_;
};

/// The same with a warm radius, and with batches.
class WarmEmbreePeer : public EmbreePeer {
public:
    explicit WarmEmbreePeer(const TriangleMesh& mesh);
    using EmbreePeer::closest;
    void closest(std::span<const Vec3> points, std::span<PeerAnswer> answers);

private:
    Box box_; ///< of the mesh
};

} // namespace proxima::bench
