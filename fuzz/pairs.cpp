// Pairs of triangles of two meshes that meet, and those of one mesh that meet each other, against a
// test of all pairs.
#include "base/check.h"
#include "decoded_mesh.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_index.h"
#include "query/contact/test_poses.h"
#include "slow_answers.h"

#include <cstddef>
#include <cstdint>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using namespace proxima;
    fuzz::Bytes bytes({data, size});
    const std::uint32_t seed = bytes.next_word();
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh_a = fuzz::decode_mesh(bytes, code);
    const TriangleMesh mesh_b = fuzz::decode_mesh(bytes, code);
    const Execution alone{.threads = {1}};
    const MeshIndex a = build_mesh_index(mesh_a, {.execution = alone}).value();
    const MeshIndex b = build_mesh_index(mesh_b, {.execution = alone}).value();
    std::vector<RigidTransform> poses = {RigidTransform()};
    proxima::testing::PoseGenerator pose(mesh_a, mesh_b, seed);
    for (int i = 0; i < 2; ++i) poses.push_back(pose());
    for (const RigidTransform& pose_b : poses) {
        const auto truth = proxima::testing::pairs_by_brute_force(mesh_a, mesh_b, pose_b);
        PROXIMA_CHECK(intersecting_pairs(a, b, pose_b) == truth);
        PROXIMA_CHECK_EQ(meshes_intersect(a, b, pose_b), !truth.empty());
        PROXIMA_CHECK_EQ(find_meeting(a, b, pose_b).has_value(), !truth.empty());
    }
    const auto pairs = find_self_intersections(a, {.execution = alone}).value().pairs;
    PROXIMA_CHECK(pairs == fuzz::self_intersections(mesh_a));
    return 0;
}
