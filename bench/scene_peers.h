// Scenes of placed meshes, ours and other libraries', behind one interface.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace proxima::bench {

/// What a ray hits first.
struct SceneRayAnswer {
    static constexpr std::uint32_t none = 0xFFFFFFFF;
    std::uint32_t instance = none;
    std::uint32_t triangle = none;
    double t = 0;
};

using ScenePairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// One mesh in many poses, on one thread. Peers leave out what they have no function for.
class ScenePeer {
public:
    ScenePeer() = default;
    ScenePeer(const ScenePeer&) = delete;
    ScenePeer& operator=(const ScenePeer&) = delete;
    virtual ~ScenePeer() = default;

    [[nodiscard]] virtual std::string name() const = 0;
    /// Makes the scene, without what is made once for the mesh.
    virtual void build(std::span<const RigidTransform> poses) = 0;
    /// Gives all instances other poses.
    virtual void move(std::span<const RigidTransform> poses) = 0;
    [[nodiscard]] virtual bool casts_rays() const { return false; }
    virtual void prepare(std::span<const Ray> /*rays*/) {}
    virtual void cast_rays() {}
    [[nodiscard]] virtual SceneRayAnswer answer(std::size_t /*ray*/) const { return {}; }
    [[nodiscard]] virtual bool finds_pairs() const { return false; }
    /// Those in contact, in any order.
    virtual ScenePairs find_pairs() { return {}; }
    /// How many pairs of boxes the broad phase alone leaves.
    virtual std::size_t count_overlaps() { return 0; }
};

[[nodiscard]] std::unique_ptr<ScenePeer> make_embree_scene_peer(const TriangleMesh& mesh);
[[nodiscard]] std::unique_ptr<ScenePeer> make_fcl_scene_peer(const TriangleMesh& mesh);

} // namespace proxima::bench
