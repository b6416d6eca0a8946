// The two programs of docs/coming_from.md for those who know FCL or Coal.
#include "coming_from/arrays.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace proxima::fcl_test {
namespace {

struct Answer {
    bool meet = false;
    double distance = 0;
};

Answer by_fcl(const std::vector<fcl::Vector3d>& points, const std::vector<fcl::Triangle>& triangles,
              double x)
{
    auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    model->beginModel();
    model->addSubModel(points, triangles);
    model->endModel();

    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.translation() = fcl::Vector3d(x, 0.1, 0.2);
    fcl::CollisionResultd meeting;
    fcl::collide<double>(model.get(), fcl::Transform3d::Identity(), model.get(), pose,
                         fcl::CollisionRequestd(), meeting);
    fcl::DistanceResultd apart;
    fcl::distance<double>(model.get(), fcl::Transform3d::Identity(), model.get(), pose,
                          fcl::DistanceRequestd(true), apart);
    return {meeting.isCollision(), apart.min_distance};
}

Answer by_proxima(const TriangleMesh& mesh, double x)
{
    const MeshIndex index =
        build_mesh_index(mesh)
            .and_then([](const MeshIndex& plain) {
                return with_slabs(plain); // optional: distances are found sooner
            })
            .value();

    const RigidTransform pose{.translation = Vec3(x, 0.1, 0.2)};
    const bool meet = meshes_intersect(index, index, pose);
    const auto apart = mesh_distance(index, index, pose);
    return {meet, apart->distance};
}

TEST(ComingFromFcl, TheSameBodiesMeetOrAreAsFarApart)
{
    const TriangleMesh mesh = *sample_mesh("sphere:20x20");
    const std::vector<fcl::Vector3d> points(mesh.positions().begin(), mesh.positions().end());
    std::vector<fcl::Triangle> triangles;
    for (const TriangleCorners& corners : mesh.triangles())
        triangles.emplace_back(corners[0], corners[1], corners[2]);
    for (const double x : {1.5, 2.5}) {
        const Answer theirs = by_fcl(points, triangles, x);
        const Answer ours = by_proxima(mesh, x);
        EXPECT_EQ(ours.meet, theirs.meet) << x;
        EXPECT_EQ(ours.meet, x < 2) << x;
        if (!ours.meet) {
            EXPECT_NEAR(ours.distance, theirs.distance, 1e-9) << x;
        }
    }
}

} // namespace
} // namespace proxima::fcl_test
