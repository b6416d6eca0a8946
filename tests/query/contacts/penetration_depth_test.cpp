#include "cancellation.h"
#include "code_of.h"
#include "geometry/exact_predicates.h"
#include "proxima/contacts.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "proxima/signed_distance.h"
#include "query/contacts/random_motions.h"
#include "query/contacts/solid_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

namespace proxima::penetration_depth_test {
namespace {

using namespace testing;

TEST(PenetrationDepth, OfCubesIsExact)
{
    const Solid cube = solid_of(make_cube());
    EXPECT_TRUE(cube.is_convex());
    EXPECT_EQ(cube.hull_error(), 0);
    const std::pair<Vec3, double> cases[] = {
        {Vec3(1.75, 0.5, 0), 0.25}, {Vec3(0.25, 0.5, -0.75), 1.25},
        {Vec3(0, 0, 0), 2},         {Vec3(2, 1, 1), 0},
        {Vec3(2, 2, 2), 0},         {Vec3(-1.999, 0.1, 0), 0.001}};
    for (const auto& [shift, truth] : cases) {
        const RigidTransform pose = moved_by(shift);
        const auto found = penetration_depth(cube, cube, pose);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->method, PenetrationMethod::convex);
        EXPECT_LE(found->lower, truth + 1e-16);
        EXPECT_GE(found->upper, truth - 1e-16);
        EXPECT_LT(found->upper - found->lower, 1e-12);
        expect_true_bounds(cube, cube, pose, *found);
    }
    const auto apart = penetration_depth(cube, cube, moved_by(Vec3(2.0001, 0, 0)));
    ASSERT_TRUE(apart);
    EXPECT_EQ(apart->method, PenetrationMethod::apart);
    EXPECT_EQ(apart->upper, 0);
}

/// Exact predicates prove that the mesh is its hull wherever its corners are exact.
TEST(PenetrationDepth, OfExactBodiesIsConvexAnywhere)
{
    std::mt19937 random(28);
    const auto tetrahedron = [&] {
        for (;;) {
            std::vector<Vec3> points;
            for (int i = 0; i < 4; ++i) {
                const auto x = static_cast<double>(random() % 9) / 8;
                const auto y = static_cast<double>(random() % 9) / 8;
                points.emplace_back(x, y, static_cast<double>(random() % 9) / 8);
            }
            const auto hull = convex_hull(points);
            if (hull->dimension() == 3) return surface_of(*hull);
        }
    };
    const auto at = [](const TriangleMesh& mesh, const Vec3& shift) {
        return solid_of(moved(mesh, [&](const Vec3& p) { return Vec3(p + shift); }));
    };
    for (int i = 0; i < 50; ++i) {
        const TriangleMesh mesh = i == 0 ? make_cube() : tetrahedron();
        const RigidTransform pose = moved_by(Vec3(0, 0.0625, 0.03125));
        const auto here = penetration_depth(solid_of(mesh), solid_of(mesh), pose);
        ASSERT_TRUE(here);
        for (const Vec3& shift : {Vec3(5e5, 5.4e6, 100), Vec3(0x1p+20, 0x1p+20, 0x1p+20),
                                  Vec3(0x1p+28, -0x1p+26, 0), Vec3(0x1p+30, 0x1p+30, 0x1p+30)}) {
            SCOPED_TRACE(shift.transpose());
            const Solid there = at(mesh, shift);
            ASSERT_TRUE(there.is_convex());
            EXPECT_EQ(there.hull_error(), 0);
            const auto found = penetration_depth(there, there, pose);
            ASSERT_TRUE(found);
            EXPECT_EQ(found->method, here->method);
            EXPECT_LE(found->lower, here->upper);
            EXPECT_GE(found->upper, here->lower);
            // 2^-46 of the coordinates of A, B and the pose.
            const double coordinates = std::sqrt(3.0) * 3 * (shift.cwiseAbs().maxCoeff() + 2);
            EXPECT_LE(found->upper - found->lower, 0x1p-46 * coordinates);
        }
    }
}

/// What heights of corners lose by rounding is that of the mesh's size, not of its coordinates.
TEST(PenetrationDepth, OfRoundBodiesHasTheSameHullErrorAnywhere)
{
    // Rounded to multiples of 2^-32, so that shifts are exact.
    const TriangleMesh ball = moved(make_sphere(20, 20), [](const Vec3& p) {
        return Vec3((0x1p+32 * p).array().round() * 0x1p-32);
    });
    const Solid here = solid_of(ball);
    ASSERT_TRUE(here.is_convex());
    EXPECT_GT(here.hull_error(), 0);
    for (const double shift : {0x1p+10, 0x1p+20}) {
        const Solid there =
            solid_of(moved(ball, [&](const Vec3& p) { return Vec3(p.array() + shift); }));
        ASSERT_TRUE(there.is_convex());
        EXPECT_NEAR(there.hull_error(), here.hull_error(), 1e-6 * here.hull_error());
    }
}

TEST(PenetrationDepth, OfABoxWithinABoxIsTheWayOut)
{
    const Solid large = solid_of(box_mesh({Vec3(-4, -5, -6), Vec3(4, 5, 6)}));
    const Solid small = solid_of(box_mesh({Vec3(-1, -1, -1), Vec3(1, 1, 1)}));
    const RigidTransform pose = moved_by(Vec3(1, 0.5, 0));
    const auto found = penetration_depth(large, small, pose);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->upper, 4, 1e-12);
    EXPECT_NEAR(found->lower, 4, 1e-12);
    EXPECT_NEAR((found->direction - Vec3::UnitX()).norm(), 0, 1e-12);
    expect_true_bounds(large, small, pose, *found);
    // The same number the other way round, in the opposite direction.
    const auto swapped = penetration_depth(small, large, moved_by(Vec3(-1, -0.5, 0)));
    ASSERT_TRUE(swapped);
    EXPECT_NEAR(swapped->upper, 4, 1e-12);
    EXPECT_NEAR((swapped->direction + Vec3::UnitX()).norm(), 0, 1e-12);
}

TEST(PenetrationDepth, HoldsThatOfTheMovedVerticesWhereThePoseIsNoRotation)
{
    const Solid a =
        solid_of(Boxes{{{Vec3(0, 0, 0), Vec3(1, 1, 1)}, {Vec3(5, 5, 5), Vec3(6, 6, 6)}}}.mesh());
    const Solid b = solid_of(box_mesh({Vec3(1000, 0, 0), Vec3(1001, 1, 1)}));
    for (const double off : {2.8e-10, -2.8e-10, 1e-4}) {
        RigidTransform pose =
            moved_by(Vec3(-1000 * (1 + off) + 0.99 + 1000 * std::min(off, 1e-9), 0, 0));
        pose.rotation *= 1 + off;
        const double truth = 1 - pose(Vec3(1000, 0, 0)).x();
        const auto found = penetration_depth(a, b, pose);
        ASSERT_TRUE(found);
        EXPECT_LE(found->lower, truth);
        EXPECT_GE(found->upper, truth);
        EXPECT_GT(found->lower, 0.99 * truth);
    }
}

TEST(PenetrationDepth, OfAWedgeWithADentIsInTheInterval)
{
    // The edge of a wedge by an angle of 1e-6 is dented by so little that hulls hardly differ.
    const double dent = 8.9e-10;
    const double slope = 0.5e-6;
    TriangleMesh wedge =
        mesh_of({Vec3(0, 0, 0), Vec3(dent, 0, 0.5), Vec3(0, 0, 1), Vec3(1, slope, 0),
                 Vec3(1, slope, 1), Vec3(1, -slope, 0), Vec3(1, -slope, 1)},
                {{1, 3, 0},
                 {1, 4, 3},
                 {1, 2, 4},
                 {1, 0, 5},
                 {1, 5, 6},
                 {1, 6, 2},
                 {3, 6, 5},
                 {3, 4, 6},
                 {0, 3, 5},
                 {2, 6, 4}});
    const Solid a = solid_of(wedge);
    EXPECT_FALSE(a.is_convex() && a.hull_error() < 0.5 * dent) << a.hull_error();
    const Solid b = solid_of(box_mesh({Vec3(-0.1, -0.1, 0.499), Vec3(0, 0.1, 0.501)}));
    for (const double part : {1.01, 1.1, 1.5}) {
        const auto found = penetration_depth(a, b, moved_by(Vec3(part * dent, 0, 0)));
        ASSERT_TRUE(found);
        // Moved back by this much it is free.
        const double enough = (part - 0.99) * dent;
        ASSERT_FALSE(solids_overlap(a, b, moved_by(Vec3(part * dent - enough, 0, 0))));
        EXPECT_LE(found->lower, enough) << part;
    }
}

TEST(PenetrationDepth, NamesAPointOfBoth)
{
    std::mt19937_64 random(3);
    const Solid cube = solid_of(make_cube());
    const Solid rings = solid_of(make_torus(16, 8));
    for (int i = 0; i < 60; ++i) {
        const Solid& a = i % 2 == 0 ? cube : rings;
        const Vec3 direction = random_direction(random);
        RigidTransform pose = random_pose(random, Vec3::Zero());
        double inside = 0;
        double outside = 5;
        for (int k = 0; k < 40; ++k) {
            const double middle = 0.5 * (inside + outside);
            pose.translation = middle * direction;
            (solids_overlap(a, cube, pose) ? inside : outside) = middle;
        }
        pose.translation = (inside - (i % 3 == 0 ? 1e-9 : 1e-3)) * direction;
        const auto found = penetration_depth(a, cube, pose);
        ASSERT_TRUE(found);
        ASSERT_NE(found->method, PenetrationMethod::apart);
        EXPECT_LE(signed_distance(a.index(), found->deepest)->distance, 1e-14) << i;
        EXPECT_LE(signed_distance(cube.index(), pose.inverse()(found->deepest))->distance, 1e-14)
            << i;
    }
}

TEST(PenetrationDepth, RefusesPosesThatAreNoneAndSearchesTooLarge)
{
    const Solid cube = solid_of(make_cube());
    for (const double bad : {HUGE_VAL, -HUGE_VAL, std::nan("")}) {
        EXPECT_EQ(code_of(penetration_depth(cube, cube, moved_by(Vec3(0, 0, bad)))),
                  ErrorCode::invalid_argument);
        RigidTransform pose;
        pose.rotation(1, 2) = bad;
        EXPECT_EQ(code_of(penetration_depth(cube, cube, pose)), ErrorCode::invalid_argument);
    }
    RigidTransform large;
    large.rotation *= 2;
    EXPECT_EQ(code_of(penetration_depth(cube, cube, large)), ErrorCode::invalid_argument);
    EXPECT_EQ(code_of(penetration_depth(cube, cube, {}, {.max_directions = 1'000'001})),
              ErrorCode::limit_exceeded);
    EXPECT_EQ(code_of(penetration_depth(cube, cube, {}, {.max_points = 1'000'001})),
              ErrorCode::limit_exceeded);
}

TEST(PenetrationDepth, OfBallsIsThatOfSpheresButForTheirFaces)
{
    const Solid ball = solid_of(make_icosphere(3));
    EXPECT_TRUE(ball.is_convex());
    EXPECT_LT(ball.hull_error(), 1e-8);
    const double inner = inner_radius(make_icosphere(3));
    std::mt19937_64 random(3);
    for (const double distance : {0.3, 1.0, 1.7, 1.95}) {
        const RigidTransform pose = random_pose(random, distance * random_direction(random));
        const auto found = penetration_depth(ball, ball, pose);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->method, PenetrationMethod::convex);
        EXPECT_LE(found->upper, 2 - distance + 1e-9);
        EXPECT_GE(found->lower, 2 * inner - distance - 1e-9);
        expect_true_bounds(ball, ball, pose, *found);
    }
}

TEST(PenetrationDepth, AConvexMeshStaysConvexWhereItsTrianglesShareNoVertices)
{
    const TriangleMesh ball = make_icosphere(4); // too large for exact predicates
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t t = 0; t < ball.triangle_count(); ++t) {
        triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        for (const Vec3& p : ball.triangle(TriangleId{t}).vertices) positions.push_back(p);
    }
    const Solid soup = solid_of(make_triangle_mesh(positions, triangles).value());
    EXPECT_TRUE(soup.is_convex());
    EXPECT_NEAR(soup.hull_error(), solid_of(ball).hull_error(), 1e-15);
}

TEST(PenetrationDepth, OfRandomHullsIsThatOfAllNormals)
{
    const std::uint64_t seed = 357;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    int overlapping = 0;
    for (int i = 0; i < 60; ++i) {
        const TriangleMesh mesh_a = random_hull(random, 5 + i % 16, 1);
        const TriangleMesh mesh_b = random_hull(random, 4 + i % 11, i % 3 == 0 ? 0.1 : 1);
        const RigidTransform pose =
            random_pose(random, 0.02 * static_cast<double>(i) * random_direction(random));
        const Solid a = solid_of(mesh_a);
        const Solid b = solid_of(mesh_b);
        ASSERT_TRUE(a.is_convex() && b.is_convex());
        const auto found = penetration_depth(a, b, pose);
        ASSERT_TRUE(found);
        expect_true_bounds(a, b, pose, *found);
        const long double truth = convex_depth_by_brute_force(mesh_a, mesh_b, pose);
        EXPECT_LE(found->lower, truth) << i;
        EXPECT_GE(found->upper, truth) << i;
        EXPECT_LT(found->upper - found->lower, 1e-11) << i;
        overlapping += found->method == PenetrationMethod::convex ? 1 : 0;
    }
    EXPECT_GT(overlapping, 30);
}

TEST(PenetrationDepth, OfBoxesJoinedIsInTheInterval)
{
    const std::uint64_t seed = 491;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    const auto whole = [&](int reach) {
        return static_cast<double>(random() % static_cast<unsigned>(reach));
    };
    const auto random_boxes = [&](std::size_t count) {
        Boxes all;
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3 lower = Vec3(whole(5), whole(5), whole(5)) - Vec3::Constant(4);
            all.boxes.push_back({lower, lower + Vec3(1 + whole(5), 1 + whole(5), 1 + whole(5))});
        }
        return all;
    };
    int overlapping = 0;
    double widest = 0;
    double sum = 0;
    for (int i = 0; i < 60; ++i) {
        const Boxes boxes_a = random_boxes(2 + static_cast<std::size_t>(i) % 3);
        const Boxes boxes_b = random_boxes(1 + static_cast<std::size_t>(i) % 2);
        const Solid a = solid_of(boxes_a.mesh());
        const Solid b = solid_of(boxes_b.mesh());
        const auto found = penetration_depth(a, b);
        ASSERT_TRUE(found);
        expect_true_bounds(a, b, {}, *found);
        if (found->method == PenetrationMethod::apart) continue;
        const double truth = boxes_depth(boxes_a, boxes_b);
        EXPECT_LE(found->lower, truth) << i;
        EXPECT_GE(found->upper, truth) << i;
        ++overlapping;
        if (truth == 0) continue;
        widest = std::max(widest, found->upper / truth);
        sum += found->upper / truth;
    }
    EXPECT_GT(overlapping, 40);
    RecordProperty("greatest_upper_by_truth", std::to_string(widest));
    RecordProperty("mean_upper_by_truth", std::to_string(sum / overlapping));
    // A box's axes are among the directions that are tried.
    EXPECT_LT(sum / overlapping, 1.05);
}

TEST(PenetrationDepth, OfLinkedRingsIsNotThatOfTheirHulls)
{
    // Two rings, one through the other's hole, that overlap a little: moving by a little is enough.
    const TriangleMesh ring = torus_mesh(1, 0.3, 48, 24);
    const Solid torus = solid_of(ring);
    EXPECT_FALSE(torus.is_convex());
    RigidTransform pose;
    pose.rotation = Eigen::AngleAxisd(std::acos(-1.0) / 2, Vec3::UnitX()).toRotationMatrix();
    pose.translation =
        Vec3(1.45, 0, 0); // A's tube reaches in to 0.7, and B's from 0.45 out to 0.75
    const auto found = penetration_depth(torus, torus, pose);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->method, PenetrationMethod::bounds);
    expect_true_bounds(torus, torus, pose, *found);
    EXPECT_GT(found->lower, 0.02);
    EXPECT_LT(found->upper, 0.06);
    EXPECT_LT(found->direction.x(), -0.9);
}

TEST(PenetrationDepth, IsTheSameMovedTurnedSwappedAndScaled)
{
    std::mt19937_64 random(357);
    const TriangleMesh mesh_a = make_torus(16, 8);
    const TriangleMesh mesh_b = make_icosphere(1);
    const Solid a = solid_of(mesh_a);
    const Solid b = solid_of(mesh_b);
    const RigidTransform pose = random_pose(random, Vec3(0.9, 0.4, 0.2));
    const auto plain = penetration_depth(a, b, pose);
    ASSERT_TRUE(plain);
    ASSERT_EQ(plain->method, PenetrationMethod::bounds);
    for (const int exponent : {-30, 30}) {
        const double factor = std::ldexp(1.0, exponent);
        const auto larger = [&](const Vec3& p) { return Vec3(factor * p); };
        RigidTransform there = pose;
        there.translation *= factor;
        const auto found = penetration_depth(solid_of(moved(mesh_a, larger)),
                                             solid_of(moved(mesh_b, larger)), there);
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->lower / factor, plain->lower, 1e-9);
        EXPECT_NEAR(found->upper / factor, plain->upper, 1e-9);
    }
    // Other searches, the same truth: the intervals have a point in common.
    const auto swapped = penetration_depth(b, a, pose.inverse());
    ASSERT_TRUE(swapped);
    EXPECT_LE(swapped->lower, plain->upper);
    EXPECT_GE(swapped->upper, plain->lower);
    const RigidTransform turned = random_pose(random, Vec3(3, -2, 1));
    const Solid a_there = solid_of(moved(mesh_a, [&](const Vec3& p) { return turned(p); }));
    RigidTransform together = turned;
    together.rotation = turned.rotation * pose.rotation;
    together.translation = turned(pose.translation);
    const auto there = penetration_depth(a_there, b, together);
    ASSERT_TRUE(there);
    EXPECT_LE(there->lower, plain->upper);
    EXPECT_GE(there->upper, plain->lower);
    EXPECT_NEAR(there->upper, plain->upper, 0.1 * plain->upper);
}

TEST(PenetrationDepth, WorksForTinyMeshesAndRefusesHugeOnes)
{
    for (const double size : {1e-200, 1e-100, 1e80}) {
        const auto scale = [&](const Vec3& p) { return Vec3(size * p); };
        const Solid cube = solid_of(moved(make_cube(), scale));
        const auto found = penetration_depth(cube, cube, moved_by(Vec3(1.75 * size, 0, 0)));
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->upper / size, 0.25, 1e-12) << size;
        EXPECT_NEAR(found->lower / size, 0.25, 1e-12) << size;
        const Solid torus = solid_of(moved(make_torus(12, 6), scale));
        const auto wide = penetration_depth(torus, cube, moved_by(Vec3(1.75 * size, 0, 0)));
        ASSERT_TRUE(wide);
        // Squares of distances of the tiniest vanish, and balls with them.
        if (size > 1e-150) {
            EXPECT_GT(wide->lower / size, 0.1) << size;
        }
        EXPECT_LT(wide->upper / size, 1) << size;
    }
    const auto huge = build_solid(build_mesh_index(moved(make_cube(), [](const Vec3& p) {
                                      return Vec3(1e160 * p);
                                  })).value());
    ASSERT_FALSE(huge);
    EXPECT_EQ(code_of(huge), ErrorCode::limit_exceeded);
}

TEST(PenetrationDepth, OfTheTiniestHasNoLowerBound)
{
    for (double size = 1e-152; size > 1e-166; size *= 0.3) {
        const auto scale = [&](const Vec3& p) { return Vec3(size * p); };
        const Solid torus = solid_of(moved(make_torus(12, 8), scale));
        const Solid cube = solid_of(moved(make_cube(), scale));
        const auto found = penetration_depth(torus, cube, moved_by(Vec3(1.5 * size, 0, 0)));
        ASSERT_TRUE(found);
        EXPECT_EQ(found->lower, 0) << size;
        EXPECT_GT(found->upper, 0) << size;
    }
}

TEST(PenetrationDepth, OfTetrahedraIsRightUpToTheEndOfDoubles)
{
    const unsigned seed = 3;
    RecordProperty("seed", static_cast<int>(seed));
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<int> number(-63, 63);
    const auto solid = [](std::vector<Vec3> corners, int exponent) {
        std::vector<TriangleCorners> sides = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
        if (orient3d(corners[0], corners[1], corners[2], corners[3]) > 0)
            for (auto& side : sides) std::swap(side[0], side[1]);
        for (Vec3& corner : corners) corner *= std::ldexp(1.0, exponent);
        return build_solid(build_mesh_index(mesh_of(corners, sides)).value());
    };
    RigidTransform pose;
    pose.rotation << 0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1;
    int found = 0;
    for (int i = 0; i < 60; ++i) {
        std::vector<Vec3> corners_a(4);
        std::vector<Vec3> corners_b(4);
        for (Vec3& corner : corners_a)
            corner = Vec3(number(random), number(random), number(random));
        for (Vec3& corner : corners_b)
            corner = Vec3(number(random), number(random), number(random));
        const auto a = solid(corners_a, 0);
        const auto b = solid(corners_b, 0);
        if (!a || !b) continue; // flat
        const auto truth = penetration_depth(*a, *b, pose);
        ASSERT_TRUE(truth);
        if (truth->method == PenetrationMethod::apart) continue;
        ++found;
        for (const int exponent :
             {-300, -500, -515, -525, -530, -535, -540, -900, -1030, -1050, -1066}) {
            SCOPED_TRACE(::testing::Message() << "2^" << exponent << ", pair " << i);
            const Solid small_a = solid(corners_a, exponent).value();
            const Solid small_b = solid(corners_b, exponent).value();
            const auto depth = penetration_depth(small_a, small_b, pose);
            ASSERT_TRUE(depth);
            EXPECT_NEAR(depth->direction.norm(), 1, 1e-12);
            EXPECT_LE(depth->lower, depth->upper);
            RigidTransform free = pose;
            free.translation += depth->translation;
            EXPECT_FALSE(solids_overlap(small_a, small_b, free));
            if (exponent < -900) continue; // bounds are some of the smallest steps apart
            EXPECT_NEAR(std::ldexp(depth->lower, -exponent), truth->lower, 1e-11);
            EXPECT_NEAR(std::ldexp(depth->upper, -exponent), truth->upper, 1e-11);
        }
    }
    EXPECT_GT(found, 20);
}

TEST(PenetrationDepth, TakesWhatIsWoundRoundTheOtherWayForFilled)
{
    // A pocket in a cube's top goes down through its bottom: below, the winding number is -1.
    std::vector<Vec3> points;
    for (const double z : {0.0, 2.0}) {
        for (const auto& [x, y] : {std::pair(0.0, 0.0), {2.0, 0.0}, {2.0, 2.0}, {0.0, 2.0}})
            points.emplace_back(x, y, z);
    }
    for (const double z : {2.0, -3.0}) {
        for (const auto& [x, y] : {std::pair(0.5, 0.5), {1.5, 0.5}, {1.5, 1.5}, {0.5, 1.5}})
            points.emplace_back(x, y, z);
    }
    std::vector<TriangleCorners> triangles = {{0, 3, 2}, {0, 2, 1}, {12, 13, 14}, {12, 14, 15}};
    for (std::uint32_t layer = 0; layer < 12; layer += 4) {
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t at = layer + i;
            const std::uint32_t next = layer + (i + 1) % 4;
            triangles.push_back({at, next, next + 4});
            triangles.push_back({at, next + 4, at + 4});
        }
    }
    const Solid pocket = solid_of(mesh_of(std::move(points), std::move(triangles)));
    const Solid small = solid_of(cube_mesh(Vec3(1, 1, -2), 0.0625));
    EXPECT_TRUE(solids_overlap(pocket, small));
    EXPECT_FALSE(solids_overlap(pocket, small, moved_by(Vec3(0, 0, 3)))); // in the pocket
    const auto found = penetration_depth(pocket, small, {});
    ASSERT_TRUE(found);
    expect_true_bounds(pocket, small, {}, *found);
    EXPECT_NEAR(found->upper, 0.5625, 1e-5);
}

TEST(PenetrationDepth, IsCancelled)
{
    const Solid torus = solid_of(make_torus(16, 8));
    const RigidTransform pose = moved_by(Vec3(0.3, 0.1, 0));
    Progress progress;
    progress.cancel();
    const auto found =
        penetration_depth(torus, torus, pose, {.execution = {.progress = &progress}});
    ASSERT_FALSE(found);
    EXPECT_EQ(code_of(found), ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::penetration_depth_test
