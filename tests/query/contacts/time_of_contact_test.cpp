#include "proxima/time_of_contact.h"

#include "base/simd.h"
#include "counted_allocations.h"
#include "index/test_meshes.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/contacts/random_motions.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <utility>

namespace proxima::time_of_contact_test {
namespace {

using namespace testing;

MeshIndex slabs_of(const TriangleMesh& mesh)
{
    return with_slabs(build_mesh_index(mesh).value()).value();
}

RigidTransform shifted(double x, double y, double z)
{
    RigidTransform pose;
    pose.translation = Vec3(x, y, z);
    return pose;
}

/// What an answer promises by itself: free where it says so, in contact where it says so.
void expect_consistent(const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion,
                       const std::optional<TimeOfContact>& found, double tolerance)
{
    if (!found) {
        EXPECT_FALSE(meshes_intersect(a, b, pose_at(motion, 1)));
        return;
    }
    ASSERT_GE(found->free_until, 0);
    ASSERT_LE(found->free_until, 1);
    if (found->evidence != ContactEvidence::intersection) {
        EXPECT_EQ(found->touches_at, HUGE_VAL);
    } else {
        EXPECT_TRUE(meshes_intersect(a, b, pose_at(motion, found->touches_at)));
        EXPECT_LE(found->touches_at, 1);
        EXPECT_LE(found->touches_at - found->free_until, std::max(tolerance, 0x1p-52) * (1 + 1e-6));
    }
    const RigidTransform pose = pose_at(motion, found->free_until);
    EXPECT_EQ(pose.rotation, found->free_pose.rotation);
    EXPECT_EQ(pose.translation, found->free_pose.translation);
    EXPECT_EQ(mesh_distance(a, b, pose)->distance, found->distance);
    if (found->touches_at > 0) {
        EXPECT_GT(found->distance, 0);
        EXPECT_NEAR(found->normal.norm(), 1, 1e-12);
    }
}

/// Steps through the motion: never a contact before the answer's.
void expect_free_before(const MeshIndex& a, const MeshIndex& b, const RigidMotion& motion,
                        const std::optional<TimeOfContact>& found, int steps)
{
    const double end = found ? found->free_until : 1;
    if (found && found->touches_at == 0) return;
    int contacts = 0;
    for (int i = 0; i <= steps; ++i)
        contacts += meshes_intersect(a, b, pose_at(motion, end * i / steps)) ? 1 : 0;
    EXPECT_EQ(contacts, 0) << "of " << steps << " steps to " << end;
}

TEST(TimeOfContact, IsThatOfTwoCubes)
{
    const MeshIndex cube = slabs_of(make_cube());
    for (const double gap : {1.0, 0.25, 1e-3, 1e-9}) {
        const RigidMotion motion = {.start = shifted(2 + gap, 0.3, 0.1),
                                    .displacement = Vec3(-4 * gap, 0, 0)};
        const auto found = time_of_contact(cube, cube, motion);
        ASSERT_TRUE(found) << gap;
        EXPECT_EQ(found->evidence, ContactEvidence::intersection);
        // 2 + gap has been rounded.
        const double truth = (motion.start.translation.x() - 2) / (4 * gap);
        EXPECT_LE(found->free_until, truth);
        EXPECT_GE(found->touches_at, truth * (1 - 1e-15));
        EXPECT_NEAR(found->free_until, truth, 1.1e-9 + 1e-12 / gap);
        EXPECT_NEAR(found->touches_at, truth, 1.1e-9 + 3e-12 / gap);
        EXPECT_NEAR((found->normal - Vec3::UnitX()).norm(), 0, 1e-12);
        EXPECT_LE(found->steps, 400U) << gap;
        expect_consistent(cube, cube, motion, found, 1e-9 + 4e-12 / gap);
    }
}

TEST(TimeOfContact, IsZeroWhereTheyTouchAtTheStart)
{
    const MeshIndex cube = slabs_of(make_cube());
    for (const RigidMotion& motion :
         {RigidMotion{.start = shifted(2, 0, 0), .displacement = Vec3(1, 0, 0)},
          RigidMotion{.start = shifted(2, 2, 2), .turn = Vec3(0, 0, 1)},
          RigidMotion{.start = shifted(0.5, 0, 0)}}) {
        const auto found = time_of_contact(cube, cube, motion);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->free_until, 0);
        EXPECT_EQ(found->touches_at, 0);
        EXPECT_EQ(found->distance, 0);
        EXPECT_EQ(found->normal, Vec3::Zero());
    }
}

TEST(TimeOfContact, SlidesAlongWithoutContact)
{
    const MeshIndex cube = slabs_of(make_cube());
    for (const double gap : {0.5, 1e-2, 1e-5, 1e-9}) {
        for (const Vec3& along : {Vec3(0, 0, 1), Vec3(0, 5, -3), Vec3(0.1, 3, 0)}) {
            const RigidMotion motion = {.start = shifted(2 + gap, -0.7, 0), .displacement = along};
            EXPECT_FALSE(time_of_contact(cube, cube, motion)) << gap << ", " << along.transpose();
        }
    }
    // Within what coordinates are rounded by nothing can be proven.
    const RigidMotion motion = {.start = shifted(2 + 0x1p-51, 0, 0), .displacement = Vec3(0, 1, 0)};
    const auto found = time_of_contact(cube, cube, motion);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->evidence, ContactEvidence::rounding);
    EXPECT_EQ(found->touches_at, HUGE_VAL);
}

TEST(TimeOfContact, SpinsOnAFloorWithoutManySteps)
{
    const MeshIndex floor = slabs_of(
        moved(make_cube(), [](const Vec3& p) { return Vec3(9 * p.x(), 9 * p.y(), p.z() - 1); }));
    const MeshIndex cube = slabs_of(make_cube());
    for (const double gap : {1e-3, 1e-6, 1e-9}) {
        for (const Vec3& along : {Vec3(0, 0, 0), Vec3(1, 0, 0)}) {
            const RigidMotion motion = {
                .start = shifted(0, 0, 1 + gap), .displacement = along, .turn = Vec3(0, 0, 3)};
            EXPECT_FALSE(time_of_contact(floor, cube, motion, {.max_steps = 400})) << gap;
        }
    }
}

/// A flat square of 2 x 2 with this many cells along a side, turned.
TriangleMesh sheet(std::uint32_t cells, const Mat3& turned)
{
    std::vector<Vec3> points;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i <= cells; ++i) {
        for (std::uint32_t k = 0; k <= cells; ++k)
            points.emplace_back(turned * Vec3(2.0 * i / cells - 1, 2.0 * k / cells - 1, 0));
    }
    for (std::uint32_t i = 0; i < cells; ++i) {
        for (std::uint32_t k = 0; k < cells; ++k) {
            const std::uint32_t at = i * (cells + 1) + k;
            triangles.push_back({at, at + cells + 1, at + 1});
            triangles.push_back({at + 1, at + cells + 1, at + cells + 2});
        }
    }
    return mesh_of(std::move(points), std::move(triangles));
}

TEST(TimeOfContact, OfFineSheetsThatSlideOrFallFlatTakesFewSteps)
{
    const Mat3 askew = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (const Mat3& turned : {Mat3(Mat3::Identity()), askew}) {
        const MeshIndex index = slabs_of(sheet(24, turned));
        const Vec3 up = turned.col(2);
        for (const double gap : {1e-2, 1e-3, 1e-5}) {
            // Boxes are drawn outward by a millionth of the size, and slabs' normals have ten bits.
            const std::uint32_t most = turned != askew && gap > 1e-4 ? 20 : 100'000;
            RigidMotion motion = {.displacement = turned * Vec3(0.5, 0.3, 0)};
            motion.start.translation = gap * up;
            EXPECT_FALSE(time_of_contact(index, index, motion, {.max_steps = most})) << gap;
            motion.turn = 0.5 * up;
            EXPECT_FALSE(time_of_contact(index, index, motion, {.max_steps = most})) << gap;
            motion = {.start = motion.start, .displacement = -2 * gap * up};
            const auto found = time_of_contact(index, index, motion);
            ASSERT_TRUE(found) << gap;
            EXPECT_LE(found->free_until, 0.5 * (1 + 1e-12));
            EXPECT_NEAR(found->free_until, 0.5, 2e-9 + 2e-13 / gap);
            EXPECT_LT(found->steps, 20'000U) << gap;
            expect_consistent(index, index, motion, found, 1e-9 + 1e-12 / gap);
        }
    }
}

TEST(TimeOfContact, OfABallThatSpinsInAShellIsNone)
{
    const TriangleMesh ball = make_icosphere(3);
    const double inner = inner_radius(ball);
    const MeshIndex b = slabs_of(ball);
    for (const double gap : {0.1, 1e-2, 1e-3}) {
        const MeshIndex a = slabs_of(
            moved(inverted(ball), [&](const Vec3& p) { return Vec3((1 + gap) / inner * p); }));
        const RigidMotion motion = {.turn = Vec3(0.3, 0.4, 0.5)};
        EXPECT_FALSE(time_of_contact(a, b, motion)) << gap;
    }
}

TEST(TimeOfContact, CanBeWatchedAndStopped)
{
    const TriangleMesh torus = make_torus(24, 12);
    const MeshIndex index = slabs_of(torus);
    // Through the hole, turning: many pairs are near.
    const RigidMotion motion = {
        .start = shifted(0.9, 0, 1.2), .displacement = Vec3(0, 0, -0.5), .turn = Vec3(0, 2, 1)};
    Progress watched;
    const auto whole = time_of_contact(index, index, motion, {.execution = {.progress = &watched}});
    EXPECT_STREQ(watched.stage(), "finding the time of contact");
    ASSERT_TRUE(whole);
    const auto same = time_of_contact(index, index, motion);
    EXPECT_EQ(whole->free_until, same->free_until);
    EXPECT_EQ(whole->steps, same->steps);
    Progress progress;
    progress.cancel();
    const auto stopped =
        time_of_contact(index, index, motion, {.execution = {.progress = &progress}});
    ASSERT_TRUE(stopped);
    EXPECT_EQ(stopped->evidence, ContactEvidence::cancelled);
    EXPECT_EQ(stopped->touches_at, HUGE_VAL);
    EXPECT_LE(stopped->free_until, whole->free_until);
    EXPECT_LT(stopped->steps, 10U);
    Progress free;
    const RigidMotion away = {.start = shifted(4, 0, 0), .displacement = Vec3(3, 0, 0)};
    EXPECT_FALSE(time_of_contact(index, index, away, {.execution = {.progress = &free}}));
    EXPECT_GT(free.fraction(), 0.99);
}

TEST(TimeOfContact, IsNoLaterThanItSays)
{
    // The cube slides past the wall at less than roundings, up to a bump.
    const auto box = [](const Vec3& lower, const Vec3& upper) {
        return moved(make_cube(), [=](const Vec3& p) {
            return Vec3(0.5 * (lower + upper) + 0.5 * p.cwiseProduct(upper - lower));
        });
    };
    const MeshIndex wall =
        slabs_of(joined(make_cube(), box(Vec3(1.05, 1.05, -0.2), Vec3(1.2, 1.5, 0.2))));
    const MeshIndex cube = slabs_of(make_cube());
    const RigidMotion motion = {.start = shifted(2 + 0x1p-51, 0, 0), .displacement = Vec3(0, 1, 0)};
    for (const double tolerance : {1e-9, 1e-3, 0.04}) {
        const auto found = time_of_contact(wall, cube, motion, {.tolerance = tolerance});
        ASSERT_TRUE(found);
        EXPECT_EQ(found->free_until, 0);
        EXPECT_EQ(found->evidence, ContactEvidence::rounding) << "the bump is at 0.05";
    }
    const RigidMotion meeting = {.start = shifted(4, 0, 0), .displacement = Vec3(-4, 0, 0)};
    const auto found = time_of_contact(cube, cube, meeting, {.tolerance = std::nan("")});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->touches_at, 0.5, 1e-10);
}

TEST(TimeOfContact, MeetsWhatItSlidesOnto)
{
    // The lower face moves in the plane of the other one's upper face: contact begins exactly at
    // the edge.
    const MeshIndex cube = slabs_of(make_cube());
    const RigidMotion motion = {.start = shifted(4, 0, 2), .displacement = Vec3(-4, 0, 0)};
    const auto found = time_of_contact(cube, cube, motion);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->evidence, ContactEvidence::intersection);
    EXPECT_LE(found->free_until, 0.5);
    EXPECT_NEAR(found->touches_at, 0.5, 2e-9);
    expect_consistent(cube, cube, motion, found, 1e-9);
}

TEST(TimeOfContact, IsThatOfABallAndAPlane)
{
    // The lowest vertex of the icosphere decides, whatever it is turned by.
    const TriangleMesh ball = make_icosphere(3);
    const TriangleMesh plane = mesh_of(
        {Vec3(-9, -9, 0), Vec3(9, -9, 0), Vec3(9, 9, 0), Vec3(-9, 9, 0)}, {{0, 1, 2}, {0, 2, 3}});
    const MeshIndex a = slabs_of(plane);
    const MeshIndex b = slabs_of(ball);
    std::mt19937_64 random(7);
    for (int i = 0; i < 20; ++i) {
        RigidMotion motion = {.start = random_pose(random, Vec3(0, 0, 3)),
                              .displacement = Vec3(1, 0.5, -4)};
        double lowest = HUGE_VAL;
        for (const Vec3& p : ball.positions())
            lowest = std::min(lowest, (motion.start.rotation * p).z());
        const double truth = (motion.start.translation.z() + lowest) / 4;
        const auto found = time_of_contact(a, b, motion);
        ASSERT_TRUE(found);
        EXPECT_LE(found->free_until, truth + 1e-15);
        EXPECT_NEAR(found->free_until, truth, 1e-9);
        EXPECT_GE(found->touches_at, truth - 1e-15);
        EXPECT_NEAR((found->normal - Vec3::UnitZ()).norm(), 0, 1e-9);
    }
}

TEST(TimeOfContact, IsThatOfATurningBar)
{
    // A bar about the z axis with its end at (5, 0), and a wall that covers [3, 5] x [2.5, 3.5].
    const TriangleMesh bar =
        moved(make_cube(), [](const Vec3& p) { return Vec3(5 * p.x(), 0.1 * p.y(), 0.1 * p.z()); });
    const TriangleMesh wall =
        moved(make_cube(), [](const Vec3& p) { return Vec3(p.x() + 4, 0.5 * p.y() + 3, p.z()); });
    const MeshIndex a = slabs_of(wall);
    const MeshIndex b = slabs_of(bar);
    // Turning from the x axis towards y, a corner of the bar's end comes to the wall's underside.
    const double half_turn = std::numbers::pi;
    RigidMotion motion = {.turn = Vec3(0, 0, half_turn)};
    const auto found = time_of_contact(a, b, motion);
    ASSERT_TRUE(found);
    // The end's corner (5, 0.1) is at height 5 sin + 0.1 cos; x = 5 cos - 0.1 sin = 4.29 is above the
    // wall's underside [3, 5] at y = 2.5.
    const double radius = std::hypot(5.0, 0.1);
    const double angle = std::asin(2.5 / radius) - std::atan2(0.1, 5.0);
    EXPECT_NEAR(found->free_until, angle / half_turn, 1.1e-9);
    EXPECT_LE(found->free_until, angle / half_turn + 1e-15);
    EXPECT_GE(found->touches_at, angle / half_turn - 1e-15);
    expect_consistent(a, b, motion, found, 1e-9);
    // The other way round the other half comes, with its side against the wall's corner (3, 3.5);
    // revolutions do not matter.
    motion.turn *= -20;
    const auto back = time_of_contact(a, b, motion);
    ASSERT_TRUE(back);
    const double other =
        std::numbers::pi - std::atan2(3.5, 3.0) - std::asin(0.1 / std::hypot(3.0, 3.5));
    EXPECT_NEAR(back->free_until, other / (20 * half_turn), 1.1e-9);
    EXPECT_LE(back->free_until, other / (20 * half_turn) + 1e-15);
    EXPECT_GE(back->touches_at, other / (20 * half_turn) - 1e-15);
    expect_free_before(a, b, motion, back, 2000);
    expect_consistent(a, b, motion, back, 1e-9);
}

TEST(TimeOfContact, IsThatOfABoxWhosePathBends)
{
    // The box at the lowest point of a circle moves along the ceiling above it, and then up.
    for (const double gap : {1e-2, 1e-3, 1e-5}) {
        const MeshIndex ceiling = slabs_of(moved(
            make_cube(), [&](const Vec3& p) { return Vec3(p.x(), p.y() + 0.02 + gap, p.z()); }));
        const MeshIndex box = slabs_of(
            moved(make_cube(), [](const Vec3& p) { return Vec3(0.02 * p + Vec3(0, -1, 0)); }));
        const RigidMotion motion = {.turn = Vec3(0, 0, 0.5)};
        const auto found = time_of_contact(ceiling, box, motion);
        ASSERT_TRUE(found) << gap;
        // Of the upper corner that leads.
        const double radius = std::hypot(0.02, 0.98);
        const double angle = std::asin((-0.98 + gap) / radius) - std::atan2(-0.98, 0.02);
        EXPECT_LE(found->free_until, angle / 0.5 * (1 + 1e-9)) << gap;
        EXPECT_NEAR(found->free_until, angle / 0.5, 1e-6) << gap;
        EXPECT_GE(found->touches_at, angle / 0.5 * (1 - 1e-9)) << gap;
        expect_free_before(ceiling, box, motion, found, 300);
        EXPECT_LT(found->steps, 1000U) << gap;
    }
}

TEST(TimeOfContact, HasTheSameBitsForEveryInstructionSet)
{
    for (const auto& [a, b] : {std::pair(make_torus(24, 12), make_icosphere(3)),
                               {make_icosphere(2), make_torus(8, 6)},
                               {sample_mesh("spaceship:1300").value(), make_cube()}}) {
        const MeshIndex index_a = slabs_of(a);
        const MeshIndex index_b = slabs_of(b);
        MotionGenerator motions(a, b, 12);
        for (int i = 0; i < 120; ++i) {
            // Wide tolerances and long turns show lanes that are told to go on by their neighbours.
            RigidMotion motion = motions();
            motion.turn *= i % 4;
            const TimeOfContactOptions options{.tolerance = i % 3 == 0 ? 1e-9 : 3e-3};
            const auto truth = time_of_contact(index_a, index_b, motion, options);
            for (const SimdTarget& target : simd_targets()) {
                force_simd_target(target);
                const auto found = time_of_contact(index_a, index_b, motion, options);
                restore_simd_targets();
                ASSERT_EQ(found.has_value(), truth.has_value());
                if (!truth) continue;
                EXPECT_EQ(found->free_until, truth->free_until) << target.name;
                EXPECT_EQ(found->touches_at, truth->touches_at) << target.name;
                EXPECT_EQ(found->normal, truth->normal) << target.name;
                EXPECT_EQ(found->steps, truth->steps) << target.name;
            }
        }
    }
}

TEST(TimeOfContact, IsNeverPastAContactOfFineSteps)
{
    const std::uint64_t seed = 20261126;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    int contacts = 0;
    int free = 0;
    for (const auto& [a, b] :
         {std::pair(make_torus(24, 12), make_icosphere(2)),
          {make_cube(), make_octahedron()},
          {sample_mesh("spaceship:1300").value(), make_torus(9, 5)},
          {without(make_icosphere(2), [](std::size_t i) { return i % 5 == 0; }), fans()}}) {
        const MeshIndex index_a = slabs_of(a);
        const MeshIndex index_b = slabs_of(b);
        MotionGenerator motions(a, b, random());
        for (int i = 0; i < 40; ++i) {
            const RigidMotion motion = motions();
            const auto found = time_of_contact(index_a, index_b, motion);
            expect_consistent(index_a, index_b, motion, found, 1e-9);
            expect_free_before(index_a, index_b, motion, found, 300);
            (found ? contacts : free) += 1;
        }
    }
    EXPECT_GT(contacts, 40);
    EXPECT_GT(free, 20);
}

TEST(TimeOfContact, IsTheSameAtAnyScaleAndFarAway)
{
    const TriangleMesh torus = make_torus(12, 6);
    MotionGenerator motions(torus, torus, 5);
    const MeshIndex plain = slabs_of(torus);
    for (int i = 0; i < 10; ++i) {
        const RigidMotion motion = motions();
        const auto truth = time_of_contact(plain, plain, motion);
        for (const int exponent : {-600, -40, 40, 500}) {
            const double factor = std::ldexp(1.0, exponent);
            const MeshIndex scaled =
                slabs_of(moved(torus, [&](const Vec3& p) { return Vec3(factor * p); }));
            RigidMotion larger = motion;
            larger.start.translation *= factor;
            larger.center *= factor;
            larger.displacement *= factor;
            const auto found = time_of_contact(scaled, scaled, larger);
            ASSERT_EQ(found.has_value(), truth.has_value()) << exponent;
            if (!truth) continue;
            EXPECT_EQ(found->free_until, truth->free_until) << exponent;
            EXPECT_EQ(found->touches_at, truth->touches_at) << exponent;
        }
    }
}

TEST(TimeOfContact, WorksForHugeAndTinyCoordinates)
{
    for (const double size : {1e-200, 1e-160, 1e160, 1e300}) {
        const MeshIndex cube =
            slabs_of(moved(make_cube(), [&](const Vec3& p) { return Vec3(size * p); }));
        const RigidMotion motion = {.start = shifted(4 * size, 0, 0),
                                    .displacement = Vec3(-4 * size, 0, 0)};
        const auto found = time_of_contact(cube, cube, motion);
        ASSERT_TRUE(found) << size;
        EXPECT_NEAR(found->free_until, 0.5, 2e-9) << size;
        const RigidMotion away = {.start = shifted(4 * size, 0, 0),
                                  .displacement = Vec3(4 * size, 0, 0)};
        EXPECT_FALSE(time_of_contact(cube, cube, away)) << size;
    }
}

TEST(TimeOfContact, IsFoundForMotionsWhoseSquaresVanish)
{
    const MeshIndex floor =
        slabs_of(mesh_of({Vec3(-1, -1, 0), Vec3(2, -1, 0), Vec3(0, 3, 0)}, {{0, 1, 2}}));
    const double least = std::numeric_limits<double>::denorm_min();
    for (const auto& [height, by] : {std::pair(1e-170, 1e-165), {1e-310, 1e-300}, {least, least}}) {
        const MeshIndex tip = slabs_of(
            mesh_of({Vec3(0.3, 0.3, height), Vec3(0.3, 0.4, 1), Vec3(0.4, 0.3, 1)}, {{0, 1, 2}}));
        for (const RigidMotion& motion : {RigidMotion{.displacement = Vec3(0, 0, -by)},
                                          RigidMotion{.turn = Vec3(-8 * by, 0, 0)}}) {
            const auto found = time_of_contact(floor, tip, motion);
            ASSERT_TRUE(found) << height;
            EXPECT_EQ(found->evidence, ContactEvidence::intersection) << height;
            EXPECT_TRUE(meshes_intersect(floor, tip, pose_at(motion, found->touches_at)));
            EXPECT_FALSE(meshes_intersect(floor, tip, found->free_pose));
        }
        EXPECT_FALSE(time_of_contact(floor, tip, {})) << height;
    }
}

TEST(TimeOfContact, TakesFewStepsForLongWaysOfSmallMeshes)
{
    const auto sized = [](const TriangleMesh& mesh, double size) {
        return moved(mesh, [&](const Vec3& p) { return Vec3(size * p); });
    };
    const MeshIndex room = slabs_of(sized(make_cube(), 1e9));
    const MeshIndex shell = slabs_of(make_icosphere(4));
    const MeshIndex point =
        slabs_of(mesh_of({Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}, {{0, 1, 2}}));
    EXPECT_FALSE(
        time_of_contact(room, point, {.displacement = Vec3(5e8, 1e8, 0)}, {.max_steps = 2000}));
    for (const double size : {1e-3, 1e-6, 1e-8}) {
        const MeshIndex cube = slabs_of(sized(make_cube(), size));
        const RigidMotion inside = {.start = shifted(-0.8, 0.1, 0),
                                    .displacement = Vec3(1.6, 0, 0)};
        EXPECT_FALSE(time_of_contact(shell, cube, inside, {.max_steps = 5000})) << size;
        const RigidMotion through = {.start = shifted(-0.8, 0.1, 0), .displacement = Vec3(9, 0, 0)};
        const auto found = time_of_contact(shell, cube, through, {.max_steps = 5000});
        ASSERT_TRUE(found) << size;
        EXPECT_EQ(found->evidence, ContactEvidence::intersection) << size;
        expect_free_before(shell, cube, through, found, 1000);
    }
}

TEST(TimeOfContact, ShowsContactsThatBeginSlowly)
{
    // A corner passes at 1.41421356237, and is in the wall for 6e-5 of the time.
    const MeshIndex wall = slabs_of(moved(make_cube(), [](const Vec3& p) {
        return Vec3(p.x() < 0 ? 1.414213561 : 2, 5 * p.y(), 5 * p.z());
    }));
    const MeshIndex cube = slabs_of(make_cube());
    const RigidMotion motion = {.turn = Vec3(0, 0, std::numbers::pi / 2)};
    const auto found = time_of_contact(wall, cube, motion);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->evidence, ContactEvidence::intersection);
    EXPECT_TRUE(meshes_intersect(wall, cube, pose_at(motion, found->touches_at)));
    EXPECT_LE(found->touches_at - found->free_until, 1e-3);
    expect_free_before(wall, cube, motion, found, 1000);
}

TEST(TimeOfContact, TakesNoMoreStepsThanAllowed)
{
    const MeshIndex cube = slabs_of(make_cube());
    const RigidMotion motion = {
        .start = shifted(3, 2.5, 0), .displacement = Vec3(-1.3, -1, 0), .turn = Vec3(1, 2, 3)};
    const auto whole = time_of_contact(cube, cube, motion);
    ASSERT_TRUE(whole);
    ASSERT_GT(whole->steps, 2U);
    const auto cut = time_of_contact(cube, cube, motion, {.max_steps = 2});
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->evidence, ContactEvidence::steps);
    EXPECT_EQ(cut->steps, 2U);
    EXPECT_LT(cut->free_until, whole->free_until);
    // No triangles are about to touch: the closest points say what the normal is.
    EXPECT_GT(cut->distance, 0.1);
    EXPECT_LT((cut->normal - (cut->point_b - cut->point_a).normalized()).norm(), 1e-12);
}

/// The margin of the proof, as the header of time_of_contact says it.
double margin_of(const TriangleMesh& a, const TriangleMesh& b, const RigidMotion& motion)
{
    const auto size = [](const TriangleMesh& mesh) {
        const Box box = bounding_box(mesh);
        return box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
    };
    const double coordinates = size(a) + size(b) + motion.center.cwiseAbs().maxCoeff() +
                               motion.start(motion.center).cwiseAbs().maxCoeff() +
                               motion.displacement.cwiseAbs().maxCoeff();
    return std::numbers::sqrt3 * 0x1p-45 * (1 + motion.turn.norm() / 4) * coordinates;
}

TEST(TimeOfContact, OfAPointDependsOnNoUnit)
{
    const TriangleMesh cube = make_cube();
    const TriangleMesh point = mesh_of_points({Vec3(0.125, 0.1, 0.3)}).value();
    const TriangleMesh twenty = mesh_of_points(std::vector<Vec3>(20, Vec3(0, 0, 0))).value();
    const RigidMotion past = {.start = shifted(4, 1.5, 0), .displacement = Vec3(-8, 0, 0)};
    const RigidMotion into = {.start = shifted(4, 0.3, 0.2),
                              .center = Vec3(0.1, 0, 0),
                              .displacement = Vec3(-8, 0, 0),
                              .turn = Vec3(0, 0.3, 1)};
    for (const auto& [a, b] :
         {std::pair(cube, point), {point, cube}, {cube, twenty}, {twenty, cube}}) {
        std::optional<TimeOfContact> truth;
        for (const int exponent : {0, -20, -45, -60, -300, -900, 20, 300, 900}) {
            const double factor = std::ldexp(1.0, exponent);
            const auto index_of = [&](const TriangleMesh& mesh) {
                return slabs_of(moved(mesh, [&](const Vec3& p) { return Vec3(factor * p); }));
            };
            const auto scaled = [&](RigidMotion motion) {
                motion.start.translation *= factor;
                motion.center *= factor;
                motion.displacement *= factor;
                return motion;
            };
            const MeshIndex index_a = index_of(a);
            const MeshIndex index_b = index_of(b);
            EXPECT_FALSE(time_of_contact(index_a, index_b, scaled(past))) << exponent;
            const auto found = time_of_contact(index_a, index_b, scaled(into));
            ASSERT_TRUE(found) << exponent;
            EXPECT_LT(found->steps, 300U) << exponent;
            if (!truth) {
                truth = found;
                EXPECT_LT(found->distance, 3 * margin_of(a, b, into));
            }
            EXPECT_EQ(found->free_until, truth->free_until) << exponent;
            EXPECT_EQ(found->normal, truth->normal) << exponent;
            EXPECT_EQ(found->steps, truth->steps) << exponent;
        }
    }
}

TEST(TimeOfContact, IsFoundWithAnyTolerance)
{
    const MeshIndex cube = slabs_of(make_cube());
    const RigidMotion along = {
        .start = {Eigen::AngleAxisd(0.12217304763960307, Vec3::UnitZ()).toRotationMatrix(),
                  Vec3(5.3, 0.1, 0.2)},
        .displacement = Vec3(-14.4, 0.2, -0.1)};
    const auto passed = time_of_contact(cube, cube, along, {.tolerance = 1});
    ASSERT_TRUE(passed);
    EXPECT_EQ(passed->evidence, ContactEvidence::intersection);
    EXPECT_NEAR(passed->touches_at, 0.22134859, 1e-6);
    const TriangleMesh ship = sample_mesh("spaceship:1300").value();
    const TriangleMesh ring = make_torus(9, 5);
    const MeshIndex a = slabs_of(ship);
    const MeshIndex b = slabs_of(ring);
    MotionGenerator motions(ship, ring, 8);
    int contacts = 0;
    for (int i = 0; i < 60; ++i) {
        const RigidMotion motion = motions();
        const auto fine = time_of_contact(a, b, motion);
        if (fine && fine->touches_at > 0) ++contacts;
        for (const double tolerance : {1e-3, 0.03, 0.3, 1.0}) {
            const auto found = time_of_contact(a, b, motion, {.tolerance = tolerance});
            ASSERT_EQ(found.has_value(), fine.has_value()) << i;
            expect_consistent(a, b, motion, found, tolerance);
            if (!fine) continue;
            EXPECT_EQ(found->evidence, ContactEvidence::intersection) << i << ", " << tolerance;
            EXPECT_LE(found->free_until, fine->touches_at) << i << ", " << tolerance;
        }
    }
    EXPECT_GT(contacts, 20);
}

TEST(TimeOfContact, IsUndecidedOnlyWhereRoundingsHideIt)
{
    // Points pass through faces between two times.
    std::mt19937_64 random(17);
    std::vector<Vec3> positions(40);
    for (Vec3& p : positions) p = random_direction(random);
    const TriangleMesh points = mesh_of_points(positions).value();
    const TriangleMesh cube = make_cube();
    const MeshIndex a = slabs_of(points);
    const MeshIndex b = slabs_of(cube);
    MotionGenerator motions(points, cube, 11);
    int undecided = 0;
    for (int i = 0; i < 100; ++i) {
        const RigidMotion motion = motions();
        for (const double tolerance : {0.0, 1e-9, 1e-3, 1.0}) {
            const auto found = time_of_contact(a, b, motion, {.tolerance = tolerance});
            if (!found || found->evidence != ContactEvidence::rounding) continue;
            EXPECT_LT(found->distance, 3 * margin_of(points, cube, motion)) << tolerance;
            ++undecided;
        }
    }
    EXPECT_GT(undecided, 100);
}

TEST(TimeOfContact, OfMeshesTooLargeForAnIndexIsNotClaimed)
{
    for (const int exponent : {1000, 1001, 1010}) {
        const double size = std::ldexp(1.0, exponent);
        const MeshIndex cube =
            slabs_of(moved(make_cube(), [&](const Vec3& p) { return Vec3(size * p); }));
        const MeshIndex ball =
            slabs_of(moved(make_icosphere(2), [&](const Vec3& p) { return Vec3(size / 2 * p); }));
        const RigidMotion motion = {.start = shifted(4 * size, size / 4, size / 8),
                                    .displacement = Vec3(-4 * size, 0, 0),
                                    .turn = Vec3(0, 0, 1)};
        for (const auto& [a, b] : {std::pair(&cube, &ball), {&ball, &cube}}) {
            const auto found = time_of_contact(*a, *b, motion);
            ASSERT_TRUE(found) << exponent;
            if (exponent == 1000) {
                EXPECT_EQ(found->evidence, ContactEvidence::intersection);
                expect_free_before(*a, *b, motion, found, 50);
            } else {
                EXPECT_EQ(found->evidence, ContactEvidence::rounding) << exponent;
                EXPECT_EQ(found->free_until, 0) << exponent;
            }
        }
    }
}

TEST(TimeOfContact, OfAnEmptyMeshIsNone)
{
    const MeshIndex cube = slabs_of(make_cube());
    EXPECT_FALSE(time_of_contact(MeshIndex(), cube, {}));
    EXPECT_FALSE(time_of_contact(cube, MeshIndex(), {}));
}

TEST(TimeOfContact, NeverAllocates)
{
    const TriangleMesh torus = make_torus(24, 12);
    const MeshIndex index = slabs_of(torus);
    MotionGenerator motions(torus, torus, 3);
    for (int i = 0; i < 10; ++i) {
        const RigidMotion motion = motions();
        const std::size_t before = allocation_count();
        const auto found = time_of_contact(index, index, motion);
        EXPECT_EQ(allocation_count(), before) << found.has_value();
    }
}

} // namespace
} // namespace proxima::time_of_contact_test
