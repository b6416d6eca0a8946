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
    /// Releases the scene, and makes what build() needs and is not timed.
    virtual void prepare_build(std::span<const RigidTransform> poses) = 0;
    /// Makes the scene, without what is made once for the mesh. \pre prepare_build was called with
    /// these poses
    virtual void build(std::span<const RigidTransform> poses) = 0;
    /// Gives all instances other poses. A pose equal to the present one may be skipped.
    virtual void move(std::span<const RigidTransform> poses) = 0;
    [[nodiscard]] virtual bool casts_rays() const { return false; }
    virtual void prepare_rays(std::span<const Ray> /*rays*/) {}
    /// Finds the closest hits. \pre prepare_rays was called since the last cast
    virtual void cast_rays() {}
    [[nodiscard]] virtual SceneRayAnswer answer(std::size_t /*ray*/) const { return {}; }
    [[nodiscard]] virtual bool finds_pairs() const { return false; }
    /// Those in contact, in any order.
    virtual ScenePairs find_pairs() { return {}; }
    /// How many pairs of boxes the broad phase alone leaves.
    virtual std::size_t count_overlaps() { return 0; }
};

/// Scene flags and build quality that Embree offers for instances: a fast or a robust traversal, and a
/// top level for rays or for moves.
enum class EmbreeTraversal : std::uint8_t { fast, robust };
enum class EmbreeTopLevel : std::uint8_t { static_high_quality, dynamic_low_quality };
[[nodiscard]] std::unique_ptr<ScenePeer> make_embree_scene_peer(const TriangleMesh& mesh,
                                                                EmbreeTraversal traversal,
                                                                EmbreeTopLevel top_level);
[[nodiscard]] std::unique_ptr<ScenePeer> make_fcl_scene_peer(const TriangleMesh& mesh);

} // namespace proxima::bench
