#include "index/triangle_lanes.h"

#include "index/test_meshes.h"
#include "query/closest/feature_distance.h"

#include <gtest/gtest.h>

namespace proxima::triangle_lanes_test {
namespace {

using namespace testing;

TEST(TriangleLanes, AreExactUpToTheirLimit)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        const Box box = bounding_box(mesh);
        const double scale = row_scale_of(mesh).up;
        const double reach = scale * box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
        int slivers = 0;
        int total = 0;
        for (const Vec3& p : proximity_points(mesh, 60, 13)) {
            const auto first = static_cast<std::uint32_t>(total) % mesh.triangle_count();
            const TriangleId id{static_cast<std::uint32_t>(first)};
            std::array<double, 8> squared{};
            triangle_distances(mesh, std::span(&id, 1), p, scale, squared);
            NearestFeature truth;
            offer_triangle(mesh, topology, id, p, {scale, 1 / scale}, truth);
            const double exact = truth.squared;
            EXPECT_FALSE(squared[0] > triangle_distance_limit(exact, reach));
            ++total;
            if (squared[0] == 0 && exact > 0) {
                ++slivers;
            } else if (exact > 1e-6 && reach < 10) {
                EXPECT_GE(squared[0], exact * (1 - 1e-6)); // or it spares nothing
            }
        }
        if (named.name == "sphere") {
            EXPECT_EQ(slivers, 0);
        }
    }
    const TriangleMesh sharp =
        mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0.01, 0)}, {{0, 1, 2}, {1, 2, 0}});
    const std::array<TriangleId, 2> ids = {TriangleId{0}, TriangleId{1}};
    std::array<double, 8> squared{};
    triangle_distances(sharp, ids, Vec3(0.5, 0, 1), 1.0, squared);
    EXPECT_EQ(squared[0], 0.0);
    EXPECT_NEAR(squared[1], 1.0, 1e-12);
}

} // namespace
} // namespace proxima::triangle_lanes_test
