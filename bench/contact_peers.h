// What intersects a mesh with itself in contact_bench: ours and FCL.
#pragma once

#include "proxima/geometry.h"
#include "proxima/intersect_meshes.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace proxima::bench {

class ContactPeer {
public:
    ContactPeer() = default;
    ContactPeer(const ContactPeer&) = delete;
    ContactPeer& operator=(const ContactPeer&) = delete;
    virtual ~ContactPeer() = default;

    [[nodiscard]] virtual std::string name() const = 0;
    [[nodiscard]] virtual double build_seconds() const = 0;
    /// Whether the mesh and itself in a pose meet; stops at the first pair.
    [[nodiscard]] virtual bool intersects(const RigidTransform& pose) = 0;
    /// All pairs as the peer gives them; kept until the next call. Returns how many.
    virtual std::size_t find_pairs(const RigidTransform& pose) = 0;
    /// What find_pairs found last, sorted.
    [[nodiscard]] virtual std::vector<TrianglePair> sorted_pairs() const = 0;
};

[[nodiscard]] std::unique_ptr<ContactPeer> make_proxima_contact_peer(const TriangleMesh& mesh);

/// Oriented boxes alone, or with swept spheres beside them.
enum class FclVolume : std::uint8_t { obb, obb_rss };
[[nodiscard]] std::unique_ptr<ContactPeer> make_fcl_contact_peer(const TriangleMesh& mesh,
                                                                 FclVolume volume);

} // namespace proxima::bench
