// Placed instances of any triangles: rays, points, view volumes, contacts and distances of a scene, moved
// as well, against its instances one by one.
#include "base/check.h"
#include "decoded_mesh.h"
#include "proxima/scene.h"
#include "query/contact/test_poses.h"
#include "query/scene/scenes_one_by_one.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace {

using namespace proxima;
using testing::RandomScene;

void expect_answers(const RandomScene& of, const Scene& scene, fuzz::Bytes& bytes,
                    const fuzz::PositionCode& code, const TriangleMesh& mesh)
{
    const std::uint8_t form = bytes.next();
    const std::uint32_t layers = form % 4 == 0 ? 1U << (form / 4 % 2) : all_layers;
    Ray ray;
    ray.origin = fuzz::decode_point(bytes, code, mesh);
    const Vec3 p = fuzz::decode_point(bytes, code, mesh);
    ray.direction = form >= 128 ? Vec3(p - ray.origin) : Vec3::Unit(form % 3);
    const SceneRayOptions ray_options = {.layers = layers};
    const std::vector<SceneHit> hits = testing::hits_one_by_one(of, ray, ray_options);
    PROXIMA_CHECK(all_hits(scene, ray, ray_options) == hits);
    PROXIMA_CHECK(closest_hit(scene, ray, ray_options) ==
                  (hits.empty() ? std::nullopt : std::optional(hits.front())));
    PROXIMA_CHECK_EQ(any_hit(scene, ray, ray_options), !hits.empty());

    SceneFeatureOptions near = {.layers = layers};
    const auto closest = testing::closest_one_by_one(of, p, near);
    PROXIMA_CHECK(testing::same(closest_feature(scene, p, near), closest));
    if (closest) {
        near.radius = form % 2 == 0 ? closest->distance : 0.75 * closest->distance;
        PROXIMA_CHECK(testing::same(closest_feature(scene, p, near),
                                    testing::closest_one_by_one(of, p, near)));
    }

    const ScenePairOptions pairs = {.layers = layers, .execution = {.threads = {1}}};
    PROXIMA_CHECK(pairs_in_contact(scene, pairs).value() ==
                  testing::contacts_one_by_one(of, pairs));
    const double distance = (p - ray.origin).cwiseAbs().maxCoeff();
    const auto found = pairs_within(scene, distance, pairs).value();
    const auto truth = testing::near_one_by_one(of, distance, pairs);
    PROXIMA_CHECK_EQ(found.size(), truth.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        PROXIMA_CHECK(found[i].a == truth[i].a && found[i].b == truth[i].b);
        PROXIMA_CHECK_EQ(found[i].nearest.distance, truth[i].nearest.distance);
    }

    std::vector<ViewPlane> planes;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 normal = Vec3::Unit(axis);
        planes.push_back({normal, -normal.dot(p.cwiseMin(ray.origin))});
        planes.push_back({-normal, normal.dot(p.cwiseMax(ray.origin))});
    }
    if (const auto volume = make_view_volume(planes)) {
        const SceneCullOptions cull = {.mode =
                                           form % 2 == 0 ? CullMode::exact : CullMode::conservative,
                                       .layers = layers,
                                       .execution = {.threads = {1}}};
        PROXIMA_CHECK(visible_ranges(scene, *volume, cull).value() ==
                      testing::ranges_one_by_one(of, *volume, cull));
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint32_t seed = bytes.next_word();
    const fuzz::PositionCode code(bytes);
    const Execution alone{.threads = {1}};
    std::vector<TriangleMesh> meshes;
    RandomScene of;
    for (int i = 0; i < 2; ++i) {
        meshes.push_back(fuzz::decode_mesh(bytes, code));
        of.shapes.push_back(build_mesh_index(meshes.back(), {.execution = alone}).value());
    }
    proxima::testing::PoseGenerator pose(meshes[0], meshes[1], seed);
    std::vector<RigidTransform> other_poses;
    for (int i = 0; i <= bytes.next() % 12; ++i) {
        const std::uint8_t form = bytes.next();
        Instance instance;
        instance.shape = form % 2;
        if (form % 8 >= 2) instance.pose = pose();
        if (form >= 192) instance.layers = form / 8 % 4;
        of.instances.push_back(instance);
        other_poses.push_back(form % 16 >= 8 ? pose() : instance.pose);
    }
    Scene scene = build_scene(of.shapes, of.instances, {.execution = alone}).value();
    expect_answers(of, scene, bytes, code, meshes[0]);

    std::vector<InstanceId> moved;
    std::vector<RigidTransform> their_poses;
    for (std::size_t i = 0; i < of.instances.size(); ++i) {
        if (bytes.next() % 2 == 0) continue;
        of.instances[i].pose = other_poses[i];
        moved.push_back(testing::id_of(i));
        their_poses.push_back(other_poses[i]);
    }
    PROXIMA_CHECK(move_in_place(scene, moved, their_poses, {.execution = alone}).has_value());
    expect_answers(of, scene, bytes, code, meshes[1]);
    return 0;
}
