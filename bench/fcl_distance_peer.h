// FCL 0.7 as a peer in distances between meshes.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <memory>
#include <string>

namespace proxima::bench {

/// One way to find the distance between two meshes; the second one is posed.
class DistancePeer {
public:
    DistancePeer() = default;
    DistancePeer(const DistancePeer&) = delete;
    DistancePeer& operator=(const DistancePeer&) = delete;
    virtual ~DistancePeer() = default;

    [[nodiscard]] virtual std::string name() const = 0;
    [[nodiscard]] virtual double build_seconds() const = 0;
    /// Both closest points are found as well. 0 or less where the meshes touch.
    [[nodiscard]] virtual double distance(const RigidTransform& pose_b) = 0;
};

enum class FclVolume : std::uint8_t { obb_rss, rss };
[[nodiscard]] std::unique_ptr<DistancePeer>
make_fcl_distance_peer(const TriangleMesh& a, const TriangleMesh& b, FclVolume volume);

} // namespace proxima::bench
