#include "cancellation.h"
#include "code_of.h"
#include "proxima/contacts.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/contacts/solid_shapes.h"

#include <array>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

namespace proxima::solid_test {
namespace {

using namespace testing;

TEST(Solid, IsRefusedWhereItHasNoInside)
{
    const auto refused = [](const TriangleMesh& mesh, const char* says) {
        const auto solid = build_solid(build_mesh_index(mesh).value());
        ASSERT_FALSE(solid);
        EXPECT_EQ(code_of(solid), ErrorCode::invalid_mesh);
        EXPECT_NE(solid.error().message.find(says), std::string::npos) << solid.error().message;
    };
    const TriangleMesh cube = make_cube();
    refused(without(cube, [](std::size_t i) { return i == 3; }), "open: 3 edges");
    std::vector<TriangleCorners> triangles(cube.triangles().begin(), cube.triangles().end());
    const std::vector<Vec3> positions(cube.positions().begin(), cube.positions().end());
    std::swap(triangles[3][0], triangles[3][1]);
    refused(mesh_of(positions, triangles), "face different ways");
    for (TriangleCorners& t : triangles) std::swap(t[0], t[1]);
    std::swap(triangles[3][0], triangles[3][1]);
    refused(mesh_of(positions, triangles), "inside out");
    refused(mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}, {0, 2, 1}}),
            "no volume");
    EXPECT_FALSE(build_solid(MeshIndex()));
    // Vertices that are not joined do no harm.
    std::vector<Vec3> apart;
    std::vector<TriangleCorners> each;
    for (const TriangleCorners& t : cube.triangles()) {
        each.push_back({static_cast<std::uint32_t>(apart.size()),
                        static_cast<std::uint32_t>(apart.size() + 1),
                        static_cast<std::uint32_t>(apart.size() + 2)});
        for (const std::uint32_t corner : t) apart.push_back(positions[corner]);
    }
    const auto solid = build_solid(build_mesh_index(mesh_of(apart, each)).value());
    ASSERT_TRUE(solid);
    const auto found = penetration_depth(*solid, *solid, moved_by(Vec3(1.5, 0, 0)));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->upper, 0.5, 1e-9);
}

TEST(Solid, HasCavitiesWhereInnerShellsFaceInward)
{
    const TriangleMesh cube = make_cube();
    const auto box = [](double size, const Vec3& center) {
        return moved(make_cube(), [=](const Vec3& p) { return Vec3(size * p + center); });
    };
    const TriangleMesh shell = joined(cube, inverted(box(0.5, Vec3::Zero())));
    const Solid hollow = solid_of(shell);
    EXPECT_FALSE(hollow.is_convex());
    const Solid small = solid_of(box(0.25, Vec3::Zero()));
    EXPECT_FALSE(solids_overlap(hollow, small)); // in the cavity
    EXPECT_FALSE(solids_overlap(small, hollow));
    EXPECT_TRUE(solids_overlap(hollow, small, moved_by(Vec3(0.75, 0, 0)))); // in the wall
    EXPECT_TRUE(solids_overlap(hollow, small, moved_by(Vec3(0.25, 0, 0)))); // touches it
    // Into the cavity is the shortest way.
    for (const double depth : {0.125, 0.01}) {
        const RigidTransform pose = moved_by(Vec3(0.25 + depth, 0, 0));
        const auto found = penetration_depth(hollow, small, pose);
        ASSERT_TRUE(found);
        expect_true_bounds(hollow, small, pose, *found);
        EXPECT_NEAR(found->upper, depth, 1e-5);
        EXPECT_LE(found->lower, depth);
        EXPECT_LT(found->direction.x(), -0.999);
        const auto regions = contact_regions(hollow, small, pose);
        ASSERT_TRUE(regions);
        ASSERT_EQ(regions->regions.size(), 1U);
        EXPECT_NEAR(regions->regions.front().depth, depth, 1e-9);
        EXPECT_LT(regions->regions.front().normal.x(), -0.999); // from A to B
    }
    // Far from the origin, and with triangles that are none.
    for (const Vec3& there : {Vec3(1.1e10, -1.3e10, 1.7e10), Vec3(-3.1e9, 7.7e9, 0),
                              Vec3(1.9e10, 2.3e10, 2.9e10), Vec3(-1.7e10, -1.1e9, 1.3e10)}) {
        const TriangleMesh far = moved(shell, [&](const Vec3& p) { return Vec3(p + there); });
        std::vector<TriangleCorners> triangles(far.triangles().begin(), far.triangles().end());
        triangles.push_back({0, 1, 1});
        triangles.push_back({2, 2, 2});
        const Solid solid =
            solid_of(mesh_of({far.positions().begin(), far.positions().end()}, triangles));
        EXPECT_FALSE(solids_overlap(solid, small, moved_by(there)));
        EXPECT_TRUE(solids_overlap(solid, small, moved_by(there + Vec3(0.75, 0, 0))));
    }
    // A solid in the cavity, and a cavity in that; components that overlap share one.
    solid_of(joined(joined(shell, box(0.25, Vec3::Zero())), inverted(box(0.125, Vec3::Zero()))));
    const TriangleMesh two = joined(box(1, Vec3::Zero()), box(1, Vec3(1, 0.1, 0.2)));
    const Solid filled = solid_of(joined(two, inverted(box(0.125, Vec3(0.5, 0, 0)))));
    const Solid tiny = solid_of(box(0.0625, Vec3(0.5, 0, 0)));
    EXPECT_TRUE(solids_overlap(filled, tiny)) << "the other component still fills it";
}

// Seen from the middle of the mesh, the volume of a component so small is less than roundings.
TEST(Solid, TellsHowSmallComponentsFaceFarFromTheMiddle)
{
    const auto box = [](double size, const Vec3& center) {
        return moved(make_cube(), [=](const Vec3& p) { return Vec3(size * p + center); });
    };
    const TriangleMesh cube = make_cube();
    const TriangleMesh shell = joined(cube, inverted(box(0.25, Vec3::Zero())));
    for (int i = 0; i < 20; ++i) {
        const Vec3 there(0.45 - 0.005 * i, 0.41 + 0.001 * i, 0.39 - 0.01 * i);
        const TriangleMesh small = box(1e-7, there);
        const auto hollow = build_solid(build_mesh_index(joined(cube, inverted(small))).value());
        ASSERT_TRUE(hollow) << i << ": " << hollow.error().message;
        const Solid smaller = solid_of(box(1e-8, there));
        EXPECT_FALSE(solids_overlap(*hollow, smaller)) << i; // in the cavity
        // A part by itself, beside a shell; turned inside out, it is no cavity of anything.
        const TriangleMesh aside = box(1e-7, there + Vec3(1, 0, 0));
        EXPECT_TRUE(build_solid(build_mesh_index(joined(shell, aside)).value())) << i;
        EXPECT_FALSE(build_solid(build_mesh_index(joined(shell, inverted(aside))).value())) << i;
    }
}

TEST(Solid, MayHaveCavitiesThatShareAVertex)
{
    // Of two tetrahedra, along every axis both ways from their common corner. Triangles begin with any of
    // their corners, that one included.
    const TriangleMesh cube = moved(make_cube(), [](const Vec3& p) { return Vec3(4 * p); });
    const std::vector<Vec3> corners = {Vec3(0, 0, 0), Vec3(1, -1, -0.5), Vec3(1, 1, -0.5),
                                       Vec3(1, 0, 1)};
    const Solid box = solid_of(box_mesh({Vec3(3, -1, -1), Vec3(6, 1, 1)}));
    const Solid speck = solid_of(box_mesh({Vec3(-0.01, -0.01, -0.01), Vec3(0.01, 0.01, 0.01)}));
    for (int axis = 0; axis < 3; ++axis) {
        for (std::uint32_t turn = 0; turn < 3; ++turn) {
            SCOPED_TRACE(::testing::Message() << axis << ", " << turn);
            std::vector<TriangleCorners> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
            for (TriangleCorners& t : triangles) std::rotate(t.begin(), t.begin() + turn, t.end());
            const auto cavity = [&](double sign) {
                std::vector<Vec3> positions;
                for (const Vec3& p : corners) {
                    Vec3& q = positions.emplace_back();
                    for (int k = 0; k < 3; ++k) q[(k + axis) % 3] = sign * p[k];
                }
                const TriangleMesh mesh = mesh_of(positions, triangles);
                return sign > 0 ? mesh : inverted(mesh);
            };
            const auto hollow =
                build_solid(build_mesh_index(joined(joined(cube, cavity(1)), cavity(-1))).value());
            ASSERT_TRUE(hollow) << describe(hollow.error());
            EXPECT_NEAR(penetration_depth(*hollow, box, {})->upper, 1, 1e-9);
            for (const double sign : {1.0, -1.0}) {
                Vec3 middle = Vec3::Zero();
                middle[axis] = 0.75 * sign;
                EXPECT_FALSE(solids_overlap(*hollow, speck, moved_by(middle)));
            }
            EXPECT_TRUE(solids_overlap(*hollow, speck));
        }
    }
}

TEST(Solid, MayHaveCavitiesBesideTrianglesOfFewerCorners)
{
    const TriangleMesh cube = moved(make_cube(), [](const Vec3& p) { return Vec3(4 * p); });
    const TriangleMesh hollow = joined(cube, inverted(make_cube()));
    std::vector<TriangleCorners> triangles(hollow.triangles().begin(), hollow.triangles().end());
    for (std::uint32_t vertex = 0; vertex < hollow.vertex_count(); ++vertex)
        triangles.push_back({vertex, vertex, vertex});
    const auto positions = hollow.positions();
    const auto solid = build_solid(
        build_mesh_index(mesh_of({positions.begin(), positions.end()}, triangles)).value());
    EXPECT_TRUE(solid) << describe(solid.error());
}

// A triangle of two corners is a segment of the surface: the hull about it is not that of the rest.
TEST(Solid, TellsHowFarSegmentsReachOutOfAConvexMesh)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1);
    std::vector<Vec3> positions(cube.positions().begin(), cube.positions().end());
    std::vector<TriangleCorners> triangles(cube.triangles().begin(), cube.triangles().end());
    positions.emplace_back(5, 0, 0);
    triangles.push_back({0, 0, static_cast<std::uint32_t>(cube.vertex_count())});
    const Solid spiked = solid_of(mesh_of(positions, triangles));
    EXPECT_FALSE(spiked.is_convex());
    const Solid small = solid_of(cube_mesh(Vec3::Zero(), 0.25));
    const RigidTransform pose = moved_by(Vec3(1.2, 0.5, 0.5));
    const auto found = penetration_depth(spiked, small, pose);
    ASSERT_TRUE(found);
    expect_true_bounds(spiked, small, pose, *found);
    EXPECT_FALSE(solids_overlap(spiked, small, moved_by(pose.translation + Vec3(0.06, 0, 0))));
    EXPECT_LE(found->lower, 0.06);
}

// A cavity within a cavity is in nothing, though a vertex that both have may seem to be in what fills the rest.
TEST(Solid, IsRefusedWhereACavityOfNothingSharesAVertex)
{
    const TriangleMesh cube = moved(make_cube(), [](const Vec3& p) { return Vec3(4 * p); });
    const auto tetrahedron = [](double width, int axis, double sign, std::uint32_t turn) {
        std::vector<Vec3> positions(4, Vec3::Zero());
        const std::array<std::array<double, 2>, 3> across = {{{-1, -0.5}, {1, -0.5}, {0, 1}}};
        for (std::size_t i = 0; i < 3; ++i) {
            positions[i + 1][axis] = sign * width;
            positions[i + 1][(axis + 1) % 3] = sign * width * width * across[i][0];
            positions[i + 1][(axis + 2) % 3] = sign * width * width * across[i][1];
        }
        std::vector<TriangleCorners> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
        for (TriangleCorners& t : triangles) std::rotate(t.begin(), t.begin() + turn, t.end());
        const TriangleMesh mesh = mesh_of(positions, triangles);
        return sign > 0 ? mesh : inverted(mesh);
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            for (std::uint32_t turn = 0; turn < 3; ++turn) {
                SCOPED_TRACE(::testing::Message() << axis << ", " << sign << ", " << turn);
                const TriangleMesh outer = tetrahedron(1, axis, sign, turn);
                const TriangleMesh inner = tetrahedron(0.5, axis, sign, turn);
                EXPECT_TRUE(build_solid(build_mesh_index(joined(cube, outer)).value()));
                const auto refused =
                    build_solid(build_mesh_index(joined(joined(cube, outer), inner)).value());
                ASSERT_FALSE(refused);
                EXPECT_NE(refused.error().message.find("in nothing"), std::string::npos)
                    << describe(refused.error());
            }
        }
    }
}

TEST(Solid, IsRefusedWhereAComponentThatFacesInwardIsNoCavity)
{
    const auto box = [](double size, double x) {
        return moved(make_cube(), [=](const Vec3& p) {
            return Vec3(size * p.x() + x, size * p.y(), size * p.z());
        });
    };
    const auto refused = [](const TriangleMesh& mesh, const char* says) {
        const auto solid = build_solid(build_mesh_index(mesh).value());
        ASSERT_FALSE(solid) << says;
        EXPECT_EQ(code_of(solid), ErrorCode::invalid_mesh);
        EXPECT_NE(solid.error().message.find(says), std::string::npos) << solid.error().message;
    };
    refused(joined(box(1, 0), inverted(box(0.5, 5))), "triangle 12 faces inward and is in nothing");
    refused(joined(joined(box(1, 0), inverted(box(0.5, 0))), inverted(box(0.25, 0))),
            "triangle 24 faces inward and is in nothing");
    refused(joined(box(1, 0), inverted(box(0.5, 0.75))), "faces inward and touches one");
    refused(joined(box(1, 0), inverted(box(0.5, 0.5))), "faces inward and touches one");
    // A vertex in common joins no components.
    refused(joined(box(1, 0), inverted(moved(make_cube(),
                                             [](const Vec3& p) {
                                                 return Vec3(0.5 * p + Vec3(0.5, 0.5, 0.5));
                                             }))),
            "faces inward and touches one");
    refused(joined(box(4, 0), inverted(joined(box(0.5, 0.1), box(0.5, 0.4)))),
            "touches itself or another");
    Progress progress;
    progress.cancel();
    const auto stopped =
        build_solid(build_mesh_index(joined(box(1, 0), inverted(box(0.5, 0)))).value(),
                    {.execution = {.progress = &progress}});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(code_of(stopped), ErrorCode::cancelled);
}

TEST(Solid, OverlapsWhereOneIsInsideOrTheyTouch)
{
    const Solid large = solid_of(box_mesh({Vec3(-4, -4, -4), Vec3(4, 4, 4)}));
    // One of two parts inside is enough.
    const Solid two =
        solid_of(joined(cube_mesh(Vec3(0, 0, 0), 0.5), cube_mesh(Vec3(20, 0, 0), 0.5)));
    EXPECT_TRUE(solids_overlap(large, two));
    EXPECT_TRUE(solids_overlap(two, large));
    EXPECT_TRUE(solids_overlap(two, large, moved_by(Vec3(20, 0, 0))));
    EXPECT_FALSE(solids_overlap(two, large, moved_by(Vec3(10, 0, 0))));
    EXPECT_TRUE(solids_overlap(large, large, moved_by(Vec3(8, 0, 0))));
    EXPECT_FALSE(solids_overlap(large, large, moved_by(Vec3(8.001, 0, 0))));
}

} // namespace
} // namespace proxima::solid_test
