// The queries of scenes, asked of all instances one by one, and rays and points to ask.
#pragma once

#include "geometry/length.h"
#include "proxima/intersect_meshes.h"
#include "proxima/scene.h"
#include "query/scene/random_scenes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace proxima::testing {

inline InstanceId id_of(std::size_t i)
{
    return InstanceId{static_cast<std::uint32_t>(i)};
}

/// All instances one by one.
inline std::vector<SceneHit> hits_one_by_one(const RandomScene& scene, const Ray& ray,
                                             const SceneRayOptions& options)
{
    std::vector<SceneHit> hits;
    if (!is_valid(ray)) return hits;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& at = scene.instances[i];
        if ((at.layers & options.layers) == 0) continue;
        for (const RayHit& hit :
             all_hits(scene.shapes[at.shape], to_instance(at.pose, ray), options.faces))
            hits.push_back({id_of(i), hit});
    }
    std::ranges::sort(hits, [](const SceneHit& a, const SceneHit& b) { return a.before(b); });
    return hits;
}

inline std::optional<SceneFeature> closest_one_by_one(const RandomScene& scene, const Vec3& p,
                                                      const SceneFeatureOptions& options)
{
    std::optional<SceneFeature> best;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& at = scene.instances[i];
        if ((at.layers & options.layers) == 0) continue;
        const Vec3 local = instance_frame(at.pose)(p);
        const auto closest =
            closest_feature(scene.shapes[at.shape], local, {.radius = options.radius});
        if (!closest) continue;
        const double distance = length_of(local - closest->point);
        if (best && best->distance <= distance) continue;
        best = {id_of(i), *closest, at.pose(closest->point), distance};
    }
    return best;
}

inline bool same(const std::optional<SceneFeature>& a, const std::optional<SceneFeature>& b)
{
    if (a.has_value() != b.has_value()) return false;
    return !a ||
           (a->instance == b->instance && a->closest.feature == b->closest.feature &&
            a->closest.triangle == b->closest.triangle && a->closest.point == b->closest.point &&
            a->point == b->point && a->distance == b->distance);
}

/// Calls visit(i, j) for pairs of instances that the options want.
template <class Visit>
void for_wanted_pairs(const RandomScene& scene, const ScenePairOptions& options, const Visit& visit)
{
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        for (std::size_t j = i + 1; j < scene.instances.size(); ++j) {
            const std::uint32_t a = scene.instances[i].layers;
            const std::uint32_t b = scene.instances[j].layers;
            if (((a & options.layers) != 0 && (b & options.others) != 0) ||
                ((b & options.layers) != 0 && (a & options.others) != 0))
                visit(i, j);
        }
    }
}

inline std::vector<InstancePair> contacts_one_by_one(const RandomScene& scene,
                                                     const ScenePairOptions& options)
{
    std::vector<InstancePair> pairs;
    for_wanted_pairs(scene, options, [&](std::size_t i, std::size_t j) {
        const Instance& a = scene.instances[i];
        const Instance& b = scene.instances[j];
        if (meshes_intersect(scene.shapes[a.shape], scene.shapes[b.shape],
                             relative_pose(a.pose, b.pose)))
            pairs.push_back({id_of(i), id_of(j)});
    });
    return pairs;
}

inline std::vector<NearInstances> near_one_by_one(const RandomScene& scene, double distance,
                                                  const ScenePairOptions& options)
{
    std::vector<NearInstances> pairs;
    for_wanted_pairs(scene, options, [&](std::size_t i, std::size_t j) {
        const Instance& a = scene.instances[i];
        const Instance& b = scene.instances[j];
        const auto near = mesh_distance(scene.shapes[a.shape], scene.shapes[b.shape],
                                        relative_pose(a.pose, b.pose), {.farthest = distance});
        if (near && near->distance <= distance) {
            pairs.push_back(
                {id_of(i), id_of(j), *near, a.pose(near->point_a), a.pose(near->point_b)});
        }
    });
    return pairs;
}

inline std::vector<InstanceRange> ranges_one_by_one(const RandomScene& scene,
                                                    const ViewVolume& volume,
                                                    const SceneCullOptions& options)
{
    std::vector<InstanceRange> ranges;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& at = scene.instances[i];
        if ((at.layers & options.layers) == 0) continue;
        std::vector<ViewPlane> planes;
        for (const ViewPlane& plane : volume.planes())
            planes.push_back(to_instance(at.pose, plane));
        visit_visible(scene.shapes[at.shape], make_view_volume(planes).value(), options.mode,
                      [&](TriangleRange range) {
                          ranges.push_back({id_of(i), range});
                          return Flow::proceed;
                      });
    }
    return ranges;
}

/// Rays and points that find what is wrong with a scene: through and from instances' own features, along
/// axes, from far away, of any length.
class SceneQueries {
public:
    SceneQueries(const RandomScene& scene, SceneGenerator& random) : scene_(scene), random_(random)
    {}

    [[nodiscard]] Vec3 place()
    {
        for (int tries = 0; tries < 8 && random_.below(4) != 0; ++tries) {
            const Instance& at = scene_.instances[random_.below(scene_.instances.size())];
            const MeshIndex& index = scene_.shapes[at.shape];
            if (index.triangle_count() == 0) continue;
            const Triangle triangle = index.parts().triangle(
                static_cast<std::uint32_t>(random_.below(index.triangle_count())));
            const double share = 0.25 * static_cast<double>(random_.below(5));
            return at.pose(Vec3(triangle[0] + share * (triangle[1] - triangle[0])));
        }
        const double far = std::pow(2.0, static_cast<double>(random_.below(6)) - 2);
        return scene_.center + far * (scene_.size + reach()) * random_.vector();
    }
    [[nodiscard]] Ray ray()
    {
        Ray ray;
        const Vec3 target = place();
        ray.origin = place();
        const std::uint64_t kind = random_.below(8);
        if (kind == 0) {
            ray.origin = target + std::ldexp(reach(), static_cast<int>(random_.below(60))) *
                                      random_.vector();
        }
        ray.direction = target - ray.origin;
        if (kind == 1) ray.direction = reach() * Vec3::Unit(static_cast<int>(random_.below(3)));
        if (kind == 2) ray.direction[static_cast<int>(random_.below(3))] = 0;
        if (kind == 3) ray.direction *= std::ldexp(1.0, static_cast<int>(random_.below(60)) - 30);
        if ((ray.direction.array() == 0).all()) ray.direction = reach() * Vec3::UnitX();
        if (random_.below(4) == 0) ray.t_max = 1;
        if (random_.below(4) == 0) ray.t_min = -1;
        return ray;
    }
    /// A length of the shapes' size.
    [[nodiscard]] double reach() const
    {
        double most = 0;
        for (const MeshIndex& index : scene_.shapes)
            if (index.triangle_count() > 0) most = std::max(most, index.parts().unscale());
        return most > 0 ? most : 1;
    }

private:
    const RandomScene& scene_;
    SceneGenerator& random_;
};

} // namespace proxima::testing
