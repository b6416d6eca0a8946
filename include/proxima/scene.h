// Many placed instances of mesh indexes: which one a ray hits first, which is closest, which are in view,
// which are in contact.
//
//     const std::vector<MeshIndex> shapes = {*tree_index, *rock_index};
//     std::vector<Instance> instances;                             // shape, pose, layers of each
//     auto scene = build_scene(shapes, instances);
//     if (auto hit = closest_hit(*scene, ray)) use(hit->instance, hit->hit.triangle);
//     auto pairs = pairs_in_contact(*scene);
//     auto next = move_instances(*scene, poses);                  // the same instances elsewhere
//     Status moved = move_in_place(*scene, some_ids, their_poses); // some of them
//
// An instance is named by its position in the list. Every answer is that of asking all instances one by
// one, bit for bit:
//
//     rays, points     moved into the instance's frame by instance_frame(pose), each number rounded a few
//                      times; then what the shape's index answers
//     pairs a < b      index of a as it is, that of b moved by relative_pose(pose a, pose b)
//     view volumes     planes moved into the instance's frame (to_instance)
//     ties             the lowest instance, and of that what its index names
//
// A tree over the instances' boxes leaves out what cannot be the answer. Instances have layers, bits of
// a mask: a query sees an instance where they have a bit in common. An instance of an empty index
// is never found.
#pragma once

#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/cull.h"
#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/view_volume.h"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace PROXIMA_EXPORT proxima {

/// The number of an instance in its scene: its position in the list.
enum class InstanceId : std::uint32_t {};

[[nodiscard]] constexpr std::uint32_t to_index(InstanceId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}

/// Layers by bits.
inline constexpr std::uint32_t all_layers = 0xFFFFFFFF;

/// An index, placed.
struct Instance {
    std::uint32_t shape = 0;           ///< which of the scene's indexes
    RigidTransform pose = {};          ///< from the index's coordinates to the scene's
    std::uint32_t layers = all_layers; ///< no bit: never found
};

/// No scene has more instances.
inline constexpr std::size_t max_instances = std::size_t{1} << 24U;

/// Coordinates of instances in a scene are no larger.
inline constexpr double max_scene_coordinate = 0x1p500;

struct SceneParts;
struct SceneOptions;

/// A value that is cheap to copy: copies share all arrays. Any number of threads may query it while no
/// thread assigns to it or moves its instances in place. Made by build_scene and move_instances. It
/// keeps the indexes' storage alive.
class Scene {
public:
    /// Without instances.
    Scene();

    [[nodiscard]] std::size_t instance_count() const noexcept;
    [[nodiscard]] std::size_t shape_count() const noexcept;

    /// \pre shape < shape_count()
    [[nodiscard]] const MeshIndex& shape(std::uint32_t shape) const noexcept;
    /// \pre id is in range
    [[nodiscard]] Instance instance(InstanceId id) const noexcept;
    /// A box about the instance, in the scene's coordinates, some percent larger than needed; empty
    /// for an instance of an empty index. \pre id is in range
    [[nodiscard]] Box bounds(InstanceId id) const noexcept;

    /// Bytes of the scene's own arrays, boxes of shapes with them, without the indexes.
    [[nodiscard]] std::uint64_t bytes() const noexcept;

    /// For the library's own searches.
    [[nodiscard]] const SceneParts& parts() const noexcept { return *parts_; }
    /// For the library's own builders. \pre parts is not null
    explicit Scene(std::shared_ptr<const SceneParts> parts) noexcept;

    // Copies only: a moved-from scene would have no parts.
    Scene(const Scene&) noexcept = default;
    Scene& operator=(const Scene&) noexcept = default;
    ~Scene() = default;

private:
    friend Status move_in_place(Scene& scene, std::span<const InstanceId> ids,
                                std::span<const RigidTransform> poses, const SceneOptions& options);
    std::shared_ptr<const SceneParts> parts_; ///< never null
};

struct SceneOptions {
    /// Stages "placing instances", steps are instances, and "drawing boxes". Budget: arrays and scratch,
    /// 700 bytes per instance, 2.5 KB per shape.
    Execution execution = {};
};

/// Results have the same bits for any number of threads. About 0.6 us per instance of 10,000 on one thread, and 5 ns
/// per triangle of each shape; 250 bytes per instance. Errors: invalid_argument (a shape out of range,
/// a pose that is not rigid or takes the shape beyond max_scene_coordinate; it names the instance),
/// limit_exceeded (more than max_instances), budget_exceeded, cancelled.
[[nodiscard]] Result<Scene> build_scene(std::span<const MeshIndex> shapes,
                                        std::span<const Instance> instances,
                                        const SceneOptions& options = {});

/// The scene with a pose for each instance in place of the one it had: shapes and layers are shared, and
/// the tree keeps its order, so that queries are slower the farther neighbours moved apart: build again
/// when they are too slow. `scene` stays as it was. Takes a quarter of the time of build_scene, or a
/// tenth where shapes are large, and less where few poses changed. Errors as build_scene, and invalid_argument for another number of poses.
[[nodiscard]] Result<Scene> move_instances(const Scene& scene,
                                           std::span<const RigidTransform> poses,
                                           const SceneOptions& options = {});

/// Gives some instances other poses, in time proportional to their number: about 0.6 us each among 10,000
/// instances, 1 to 2 us among a million. Where an instance is listed twice, its last pose counts. Answers are
/// those of a scene built with these poses, bit for bit. Copies of the scene stay as they were: while there
/// is one, all arrays are copied first, so let go of old copies before. All boxes are drawn again, as by
/// move_instances, where more than an eighth of the instances move, or one leaves the box that held
/// all instances when they were last drawn, or all had come to need less than half of that box. Not thread safe for this scene; other threads may use copies of
/// it. Errors: those of move_instances, and invalid_argument for an instance that is out of range. After an
/// error, and where memory runs out (std::bad_alloc), the scene is as it was.
[[nodiscard]] Status move_in_place(Scene& scene, std::span<const InstanceId> ids,
                                   std::span<const RigidTransform> poses,
                                   const SceneOptions& options = {});

/// Takes the scene's coordinates into those of an instance with this pose: pose.inverse(), as the
/// library computes it.
[[nodiscard]] RigidTransform instance_frame(const RigidTransform& pose) noexcept;

/// Takes the coordinates of an instance with pose `b` into those of one with pose `a`: R_a^T R_b and
/// R_a^T (t_b - t_a), each number rounded a few times, always in the same way.
[[nodiscard]] RigidTransform relative_pose(const RigidTransform& a,
                                           const RigidTransform& b) noexcept;

/// The ray in the coordinates of an instance: origin and direction moved by instance_frame(pose), t as
/// it is.
[[nodiscard]] Ray to_instance(const RigidTransform& pose, const Ray& ray) noexcept;

/// The plane in the coordinates of an instance: R^T n and n . t + offset, each number rounded a few
/// times.
[[nodiscard]] ViewPlane to_instance(const RigidTransform& pose, const ViewPlane& plane) noexcept;

/// A hit of a ray and an instance.
struct SceneHit {
    InstanceId instance{};
    RayHit hit = {}; ///< t is that of the scene's ray as well
    friend bool operator==(const SceneHit&, const SceneHit&) = default;

    /// Whether it comes before another hit of its ray: by t, then instance, then triangle.
    [[nodiscard]] bool before(const SceneHit& other) const noexcept
    {
        if (hit.t != other.hit.t) return hit.t < other.hit.t;
        if (instance != other.instance) return instance < other.instance;
        return hit.triangle < other.hit.triangle;
    }
};

struct SceneRayOptions {
    Faces faces = Faces::both;
    std::uint32_t layers = all_layers; ///< that the ray sees
    /// Of batches: stage "casting rays", steps are rays; budget: three times all hits.
    Execution execution = {};
};

/// The first hit. An invalid ray hits nothing. Real-time safe: noexcept, no allocation, no lock; any
/// number of threads. About 1 us among 10,000 instances of a scanned
/// model, 6 us among a million.
[[nodiscard]] std::optional<SceneHit> closest_hit(const Scene& scene, const Ray& ray,
                                                  const SceneRayOptions& options = {}) noexcept;

/// Whether there is a hit. As closest_hit, and quicker.
[[nodiscard]] bool any_hit(const Scene& scene, const Ray& ray,
                           const SceneRayOptions& options = {}) noexcept;

/// Calls visitor(hit) for every hit, in no particular order, until it returns Flow::stop. As
/// closest_hit; the visitor must not throw.
void visit_hits(const Scene& scene, const Ray& ray, const SceneRayOptions& options,
                FunctionRef<Flow(const SceneHit&)> visitor) noexcept;

/// All hits in order, in a vector that it allocates.
[[nodiscard]] std::vector<SceneHit> all_hits(const Scene& scene, const Ray& ray,
                                             const SceneRayOptions& options = {});

/// The first hits of many rays, and whether there are hits. Answers are those of single rays. Errors:
/// invalid_argument (sizes differ, or a ray is invalid: which), cancelled, after which answers are written
/// in part.
[[nodiscard]] Status closest_hits(const Scene& scene, std::span<const Ray> rays,
                                  std::span<std::optional<SceneHit>> hits,
                                  const SceneRayOptions& options = {});
[[nodiscard]] Status any_hits(const Scene& scene, std::span<const Ray> rays, std::span<bool> hits,
                              const SceneRayOptions& options = {});

/// Hits of many rays: those of ray i are hits[first[i]] to hits[first[i + 1] - 1].
struct SceneHitLists {
    std::vector<std::size_t> first;
    std::vector<SceneHit> hits;
};
/// All hits of many rays, those of each in order. Errors: as closest_hits, and budget_exceeded (more hits than
/// fit).
[[nodiscard]] Result<SceneHitLists> all_hits(const Scene& scene, std::span<const Ray> rays,
                                             const SceneRayOptions& options = {});

/// The feature of all instances that is closest to a point.
struct SceneFeature {
    InstanceId instance{};
    ClosestFeature closest = {}; ///< as the shape's index says it, in its coordinates
    Vec3 point = Vec3::Zero();   ///< closest.point in the scene
    /// From the query to the closest point, as computed in the index's coordinates; right also where
    /// squares of distances leave the doubles.
    double distance = std::numeric_limits<double>::infinity();
};

struct SceneFeatureOptions {
    /// Nothing farther is found, up to a rounding. None is where it is NaN or below 0.
    double radius = std::numeric_limits<double>::infinity();
    std::uint32_t layers = all_layers;
    Execution execution = {}; ///< of batches: stage "closest features", steps are points
};

/// The closest feature of all instances: that of the least distance as computed, of the lowest instance.
/// Nothing where the point is not finite. Real-time safe: noexcept, no allocation, no lock; any number of
/// threads. 3 to 6 us among 10,000 instances.
[[nodiscard]] std::optional<SceneFeature>
closest_feature(const Scene& scene, const Vec3& p,
                const SceneFeatureOptions& options = {}) noexcept;

/// Those of many points. Answers are those of single queries. Errors: invalid_argument (sizes differ, a
/// point is not finite: which), cancelled.
[[nodiscard]] Status closest_features(const Scene& scene, std::span<const Vec3> points,
                                      std::span<std::optional<SceneFeature>> answers,
                                      const SceneFeatureOptions& options = {});

/// Calls visitor(id) for the instances whose bounds() have a point in common with the box, each once,
/// in no particular order, until it returns Flow::stop. Real-time safe if the visitor is, which must not
/// throw. Nothing where the box is empty or not finite.
void visit_instances(const Scene& scene, const Box& box, std::uint32_t layers,
                     FunctionRef<Flow(InstanceId)> visitor) noexcept;

struct SceneCullOptions {
    CullMode mode = CullMode::conservative;
    std::uint32_t layers = all_layers;
    Execution execution = {}; ///< stage "culling instances"; budget: three times the answer
};

/// Rows of an instance's index.
struct InstanceRange {
    InstanceId instance{};
    TriangleRange rows = {};
    friend bool operator==(const InstanceRange&, const InstanceRange&) = default;
};

/// The instances that have a visible triangle, ascending. The same for any number of threads. Allocates.
/// Errors: invalid_argument where a plane in an instance's coordinates is not finite (the lowest such
/// instance), budget_exceeded, cancelled.
[[nodiscard]] Result<std::vector<InstanceId>>
visible_instances(const Scene& scene, const ViewVolume& volume,
                  const SceneCullOptions& options = {});

/// The visible triangles by instance, ascending, then by ranges as visible_ranges gives them. Allocates.
/// Errors as visible_instances.
[[nodiscard]] Result<std::vector<InstanceRange>>
visible_ranges(const Scene& scene, const ViewVolume& volume, const SceneCullOptions& options = {});

/// Two instances, a < b.
struct InstancePair {
    InstanceId a{};
    InstanceId b{};

    // NOLINTNEXTLINE(modernize-use-nullptr): of the defaulted comparison's own text
    friend auto operator<=>(const InstancePair&, const InstancePair&) = default;
};

struct ScenePairOptions {
    /// Of each pair one instance has a bit of `layers` and the other one of `others`: a robot and its
    /// surroundings, but not the surroundings among themselves.
    std::uint32_t layers = all_layers;
    std::uint32_t others = all_layers;
    Execution execution =
        {}; ///< stage "finding pairs", steps are instances; budget: three times the pairs, 4 bytes an instance
};

/// All pairs of instances whose surfaces meet (meshes_intersect), ascending, each once. Touching
/// counts. The same for any number of threads. Errors: budget_exceeded (more pairs than fit), cancelled.
/// Allocates. About 0.3 us per instance and 1 to 30 us per pair whose boxes overlap.
[[nodiscard]] Result<std::vector<InstancePair>>
pairs_in_contact(const Scene& scene, const ScenePairOptions& options = {});

/// Two instances that are near each other.
struct NearInstances {
    InstanceId a{};
    InstanceId b{};
    MeshDistance nearest = {};   ///< in the coordinates of a's index
    Vec3 point_a = Vec3::Zero(); ///< nearest.point_a in the scene
    Vec3 point_b = Vec3::Zero();
};

/// All pairs of instances whose surfaces are at most `distance` apart (mesh_distance), ascending. Errors as
/// pairs_in_contact, and invalid_argument where the distance is NaN, negative or infinite.
[[nodiscard]] Result<std::vector<NearInstances>> pairs_within(const Scene& scene, double distance,
                                                              const ScenePairOptions& options = {});

/// The broad phase alone: all pairs of instances whose bounds() are at most `distance` apart,
/// ascending. Errors as pairs_within.
[[nodiscard]] Result<std::vector<InstancePair>>
overlapping_bounds(const Scene& scene, double distance = 0, const ScenePairOptions& options = {});

} // namespace proxima
