#include "proxima/mesh_distance.h"

#include "base/simd.h"
#include "cancellation.h"
#include "counted_allocations.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_distance.h"
#include "index/test_meshes.h"
#include "oracles/quad_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <tuple>

namespace proxima::mesh_distance_test {
namespace {

using namespace testing;

/// The index of a mesh, with slabs.
MeshIndex index_of(const TriangleMesh& mesh)
{
    return with_slabs(build_mesh_index(mesh).value()).value();
}

/// All pairs in doubles: the one with the least distance, then the lowest ids.
MeshDistance distance_by_brute_force(const TriangleMesh& a, const TriangleMesh& b,
                                     const RigidTransform& pose_b)
{
    MeshDistance best;
    double least = std::numeric_limits<double>::infinity();
    std::vector<Triangle> moved;
    for (std::uint32_t k = 0; k < b.triangle_count(); ++k)
        moved.push_back(pose_b(b.triangle(TriangleId{k})));
    for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
        const Triangle triangle = a.triangle(TriangleId{i});
        for (std::uint32_t k = 0; k < b.triangle_count(); ++k) {
            const ClosestTrianglePoints pair = closest_points(triangle, moved[k]);
            if (!(pair.squared_distance < least)) continue;
            least = pair.squared_distance;
            best.distance = std::sqrt(least);
            best.point_a = pair.first.point;
            best.point_b = pair.second.point;
            best.part_a = pair.first.part;
            best.part_b = pair.second.part;
            best.triangle_a = TriangleId{i};
            best.triangle_b = TriangleId{k};
        }
    }
    return best;
}

/// Turns by multiples of 90 degrees and whole steps: exact on whole points.
RigidTransform whole_pose(std::mt19937_64& random, int reach)
{
    RigidTransform pose;
    const int shift = static_cast<int>(random() % 3);
    for (int i = 0; i < 3; ++i) {
        pose.rotation.row(i).setZero();
        pose.rotation(i, (i + shift) % 3) = 1;
        pose.translation[i] =
            static_cast<double>(random() % static_cast<unsigned>(2 * reach + 1)) - reach;
    }
    if (random() % 2 == 0) {
        pose.rotation.row(0) *= -1;
        pose.rotation.row(1) *= -1;
    }
    return pose;
}

class PoseGenerator {
public:
    PoseGenerator(const TriangleMesh& a, const TriangleMesh& b, std::uint64_t seed)
        : a_(bounding_box(a)), b_(bounding_box(b)), random_(seed)
    {
        size_ = std::max({a_.extent().norm(), b_.extent().norm(), 1e-300});
    }

    RigidTransform operator()()
    {
        switch (below(8)) {
        case 0:
            return whole_pose(random_, 5);
        case 1: // one within the other, or through it
            return at(0.1 * unit() * direction());
        case 2: // nearly touching
            return at(size_ * (0.5 + 0.5 * unit()) * Vec3::Unit(static_cast<int>(below(3))));
        case 3: // far
            return at(std::ldexp(size_, static_cast<int>(below(24))) * direction());
        case 4: { // not turned
            RigidTransform pose = at(1.5 * size_ * unit() * direction());
            pose.rotation = Mat3::Identity();
            return pose;
        }
        default:
            return at(1.5 * size_ * unit() * direction());
        }
    }

private:
    std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
    double unit() { return std::uniform_real_distribution<double>()(random_); }
    Vec3 direction()
    {
        std::normal_distribution<double> normal;
        const double x = normal(random_);
        const double y = normal(random_);
        return Vec3(x, y, normal(random_)).normalized();
    }
    /// Turned at random, B's center that much from A's.
    RigidTransform at(const Vec3& apart)
    {
        RigidTransform pose;
        pose.rotation = Eigen::AngleAxisd(6.3 * unit(), direction()).toRotationMatrix();
        pose.translation = a_.center() + apart - pose.rotation * b_.center();
        return pose;
    }

    Box a_;
    Box b_;
    double size_;
    std::mt19937_64 random_;
};

/// Largest coordinate, of which roundings are small parts.
double coordinates_of(const TriangleMesh& a, const TriangleMesh& b, const RigidTransform& pose)
{
    double largest = pose.translation.cwiseAbs().maxCoeff();
    for (const TriangleMesh* mesh : {&a, &b}) {
        for (const Vec3& p : mesh->positions())
            largest = std::max(largest, p.cwiseAbs().maxCoeff());
    }
    return largest;
}

void expect_equal(const MeshDistance& found, const MeshDistance& truth, const TriangleMesh& a,
                  const TriangleMesh& b, const RigidTransform& pose)
{
    ASSERT_EQ(found.distance, truth.distance);
    const Triangle on_a = a.triangle(found.triangle_a);
    const Triangle on_b = pose(b.triangle(found.triangle_b));
    const double rounding = 1e-14 * coordinates_of(a, b, pose);
    EXPECT_LE(oracle::root(oracle::squared_distance(oracle::QuadPoint(found.point_a), on_a)),
              rounding);
    EXPECT_LE(oracle::root(oracle::squared_distance(oracle::QuadPoint(found.point_b), on_b)),
              rounding);
    if (found.distance == 0) {
        EXPECT_EQ(found.point_a, found.point_b);
        EXPECT_TRUE(triangles_meet(on_a, on_b));
        return;
    }
    EXPECT_EQ(found.triangle_a, truth.triangle_a);
    EXPECT_EQ(found.triangle_b, truth.triangle_b);
    EXPECT_EQ(found.point_a, truth.point_a);
    EXPECT_EQ(found.point_b, truth.point_b);
    EXPECT_EQ(found.part_a, truth.part_a);
    EXPECT_EQ(found.part_b, truth.part_b);
}

/// Small enough that all pairs are soon asked.
std::vector<NamedMesh> small_meshes()
{
    std::vector<NamedMesh> meshes;
    for (NamedMesh& named : proximity_meshes())
        if (named.mesh.triangle_count() <= 100) meshes.push_back(std::move(named));
    meshes.push_back({"small sphere", sphere_mesh(Vec3(1, 2, 3), 1.5, 7, 9)});
    meshes.push_back({"small torus", torus_mesh(2.0, 0.5, 10, 6)});
    meshes.push_back({"tiny torus", moved(torus_mesh(2e-6, 1e-6, 8, 6),
                                          [](const Vec3& p) { return Vec3(p + Vec3(1, 1, 1)); })});
    meshes.push_back({"far sphere", sphere_mesh(Vec3(1e6, -2e6, 3e6), 1.0, 5, 6)});
    return meshes;
}

TEST(MeshDistance, AgreesWithAllPairs)
{
    const std::vector<NamedMesh> meshes = small_meshes();
    std::vector<MeshIndex> indexes;
    for (const NamedMesh& named : meshes) indexes.push_back(index_of(named.mesh));
    constexpr std::uint64_t seed = 11;
    int touching = 0;
    int apart = 0;
    std::uint64_t turn = 0;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        for (std::size_t k = 0; k < meshes.size(); ++k) {
            PoseGenerator poses(meshes[i].mesh, meshes[k].mesh, seed + ++turn);
            for (int pose_number = 0; pose_number < 3; ++pose_number) {
                SCOPED_TRACE(meshes[i].name + " and " + meshes[k].name + ", seed " +
                             std::to_string(seed + turn) + ", pose " + std::to_string(pose_number));
                const RigidTransform pose = poses();
                const MeshDistance truth =
                    distance_by_brute_force(meshes[i].mesh, meshes[k].mesh, pose);
                const MeshDistance found = mesh_distance(indexes[i], indexes[k], pose).value();
                expect_equal(found, truth, meshes[i].mesh, meshes[k].mesh, pose);
                if (HasFatalFailure()) return;
                ++(truth.distance == 0 ? touching : apart);
            }
        }
    }
    EXPECT_GT(touching, 300);
    EXPECT_GT(apart, 1000);
}

TEST(MeshDistance, IsTheSameFromAnyStartRangeAndInstructionSet)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 60, 40);
    const TriangleMesh ship = sample_mesh("spaceship:1300").value();
    const MeshIndex a = index_of(torus);
    const MeshIndex b = index_of(ship);
    PoseGenerator poses(torus, ship, 5);
    MeshDistance last;
    const std::size_t before = allocation_count();
    std::size_t uncounted = 0;
    for (int i = 0; i < 60; ++i) {
        const RigidTransform pose = poses();
        const MeshDistance truth = mesh_distance(a, b, pose).value();
        const auto expect_same = [&](const std::optional<MeshDistance>& found) {
            ASSERT_TRUE(found.has_value());
            ASSERT_EQ(found->distance, truth.distance);
            if (truth.distance == 0) return;
            ASSERT_EQ(found->triangle_a, truth.triangle_a);
            ASSERT_EQ(found->triangle_b, truth.triangle_b);
            ASSERT_EQ(found->point_a, truth.point_a);
            ASSERT_EQ(found->point_b, truth.point_b);
        };
        expect_same(mesh_distance(a, b, pose, {.start_from = &last}));
        expect_same(mesh_distance(a, b, pose, {.farthest = truth.distance}));
        expect_same(
            mesh_distance(a, b, pose, {.farthest = 2 * truth.distance, .start_from = &last}));
        if (truth.distance > 0) {
            const double less = std::nextafter(truth.distance, 0.0);
            ASSERT_FALSE(mesh_distance(a, b, pose, {.farthest = less}).has_value());
            ASSERT_FALSE(
                mesh_distance(a, b, pose, {.farthest = less, .start_from = &truth}).has_value());
        }
        EXPECT_FALSE(mesh_distance(a, b, pose, {.farthest = -1}).has_value());
        last = truth;

        const std::size_t so_far = allocation_count();
        for (const SimdTarget& target : simd_targets()) {
            force_simd_target(target);
            const MeshDistance other = mesh_distance(a, b, pose).value();
            restore_simd_targets();
            ASSERT_EQ(other.distance, truth.distance) << target.name;
            ASSERT_EQ(other.row_a, truth.row_a) << target.name;
            ASSERT_EQ(other.row_b, truth.row_b) << target.name;
            ASSERT_EQ(other.point_a, truth.point_a) << target.name;
            ASSERT_EQ(other.point_b, truth.point_b) << target.name;
        }
        uncounted += allocation_count() - so_far; // lists of targets
    }
    EXPECT_EQ(allocation_count() - before, uncounted);
}

TEST(MeshDistance, IgnoresAStartFromOtherMeshes)
{
    const MeshIndex small = index_of(sample_mesh("cube").value());
    const MeshIndex large = index_of(sample_mesh("sphere:30x30").value());
    const RigidTransform apart{.translation = {3, 0.2, 0.1}};
    const MeshDistance expected = mesh_distance(small, small, apart).value();
    MeshDistance other = mesh_distance(large, large, apart).value();
    ASSERT_GE(other.row_a, small.triangle_count());
    for (const std::uint32_t row : {other.row_b, std::uint32_t{0}, ~std::uint32_t{0}}) {
        other.row_b = row;
        const auto found = mesh_distance(small, small, apart, {.start_from = &other});
        ASSERT_TRUE(found);
        EXPECT_EQ(found->distance, expected.distance);
        EXPECT_EQ(found->triangle_a, expected.triangle_a);
        EXPECT_EQ(found->triangle_b, expected.triangle_b);
    }
}

TEST(MeshDistance, IsTheSameWithoutSlabs)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 60, 40);
    const TriangleMesh ship = sample_mesh("spaceship:1300").value();
    const MeshIndex a = build_mesh_index(torus).value();
    const MeshIndex b = build_mesh_index(ship).value();
    const MeshIndex slabs_a = with_slabs(a).value();
    const MeshIndex slabs_b = with_slabs(b).value();
    EXPECT_FALSE(a.has_slabs());
    EXPECT_TRUE(slabs_a.has_slabs());
    PoseGenerator poses(torus, ship, 7);
    for (int i = 0; i < 60; ++i) {
        SCOPED_TRACE(i);
        const RigidTransform pose = poses();
        const MeshDistance truth = mesh_distance(slabs_a, slabs_b, pose).value();
        for (const MeshDistance& found :
             {mesh_distance(a, b, pose).value(), mesh_distance(slabs_a, b, pose).value(),
              mesh_distance(a, slabs_b, pose).value()}) {
            ASSERT_EQ(found.distance, truth.distance);
            if (truth.distance == 0) continue; // any common point
            ASSERT_EQ(found.row_a, truth.row_a);
            ASSERT_EQ(found.row_b, truth.row_b);
            ASSERT_EQ(found.point_a, truth.point_a);
            ASSERT_EQ(found.point_b, truth.point_b);
        }
    }
}

TEST(MeshDistance, IsSymmetric)
{
    const TriangleMesh sphere = sphere_mesh(Vec3(3, 2, 1), 1.0, 20, 24);
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 40, 30);
    const MeshIndex a = index_of(sphere);
    const MeshIndex b = index_of(torus);
    PoseGenerator poses(sphere, torus, 6);
    for (int i = 0; i < 200; ++i) {
        SCOPED_TRACE(i);
        const RigidTransform pose = poses();
        const double rounding = 1e-13 * coordinates_of(sphere, torus, pose);
        const MeshDistance one = mesh_distance(a, b, pose).value();
        const MeshDistance other = mesh_distance(b, a, pose.inverse()).value();
        EXPECT_NEAR(one.distance, other.distance, rounding);
    }
}

TEST(MeshDistance, OfSpheresIsKnown)
{
    // Polyhedra within the spheres, with vertices at the poles.
    const TriangleMesh around = sphere_mesh(Vec3::Zero(), 1.0, 40, 60);
    const MeshIndex sphere = index_of(around);
    const auto apart = [&](double z) {
        RigidTransform pose;
        pose.translation = Vec3(0, 0, z);
        return mesh_distance(sphere, sphere, pose).value();
    };
    const MeshDistance near = apart(2.5);
    EXPECT_EQ(near.distance, 0.5);
    EXPECT_EQ(near.point_a, Vec3(0, 0, 1));
    EXPECT_EQ(near.point_b, Vec3(0, 0, 1.5));
    EXPECT_LE(near.part_a, TrianglePart::corner_2);
    EXPECT_EQ(apart(2).distance, 0);
    EXPECT_EQ(apart(2).point_a, Vec3(0, 0, 1));
    EXPECT_EQ(apart(std::nextafter(2.0, 3.0)).distance, 0x1p-51);
    EXPECT_EQ(apart(1.5).distance, 0);
    EXPECT_EQ(apart(0).distance, 0);
    EXPECT_EQ(apart(0x1p40).distance, 0x1p40 - 2);
    EXPECT_EQ(apart(0x1p100).distance, 0x1p100);
    // Of surfaces: one within the other is not near.
    const MeshIndex small = index_of(sphere_mesh(Vec3::Zero(), 0.25, 40, 60));
    const double inner = mesh_distance(sphere, small)->distance;
    EXPECT_LE(inner, 0.75);
    EXPECT_GE(inner, inner_radius(around) - 0.25);
}

/// The answer to both meshes and their pose 2^power times as large is that to them, as large. Of
/// triangles at one distance any may be named: which, where products underflow, is another.
void expect_scaled(const TriangleMesh& a, const TriangleMesh& b, const RigidTransform& pose,
                   int power, const MeshDistance& truth)
{
    const double scale = std::ldexp(1.0, power);
    const auto times = [&](const Vec3& p) { return Vec3(scale * p); };
    RigidTransform scaled = pose;
    scaled.translation *= scale;
    const MeshDistance found =
        mesh_distance(index_of(moved(a, times)), index_of(moved(b, times)), scaled).value();
    EXPECT_EQ(found.distance, scale * truth.distance);
    EXPECT_EQ(found.point_a, times(truth.point_a));
    EXPECT_EQ(found.point_b, times(truth.point_b));
    EXPECT_EQ(found.triangle_a, truth.triangle_a);
    EXPECT_EQ(found.triangle_b, truth.triangle_b);
}

TEST(MeshDistance, ScalesByPowersOfTwo)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 40, 30);
    const TriangleMesh sphere = sphere_mesh(Vec3(0.5, 0.1, 0.2), 0.3, 12, 16);
    const MeshIndex a = index_of(torus);
    const MeshIndex b = index_of(sphere);
    PoseGenerator poses(torus, sphere, 8);
    for (int i = 0; i < 30; ++i) {
        SCOPED_TRACE(i);
        RigidTransform pose = poses();
        const MeshDistance truth = mesh_distance(a, b, pose).value();
        for (const int power : {-20, 20, -200, 200}) {
            expect_scaled(torus, sphere, pose, power, truth);
        }
    }
}

TEST(MeshDistance, IsRightAtAnyScale)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 12, 8);
    const TriangleMesh sphere = sphere_mesh(Vec3(0.5, 0.25, 0.125), 0.25, 6, 8);
    const MeshIndex a = index_of(torus);
    const MeshIndex b = index_of(sphere);
    PoseGenerator poses(torus, sphere, 9);
    for (int i = 0; i < 12; ++i) {
        const RigidTransform pose = poses();
        const MeshDistance truth = mesh_distance(a, b, pose).value();
        for (const int power : {-900, -600, -400, -300, 300, 330}) {
            SCOPED_TRACE(::testing::Message() << "pose " << i << ", 2^" << power);
            expect_scaled(torus, sphere, pose, power, truth);
        }
    }
}

TEST(MeshDistance, IsRightAtAnyDistance)
{
    const auto apart = [](double size, double x) {
        const MeshIndex cube = index_of(cube_mesh(Vec3::Zero(), size));
        RigidTransform pose;
        pose.translation = Vec3(x, 0, 0);
        return mesh_distance(cube, cube, pose).value();
    };
    for (const double x : {1e100, 1e149, 1e155, 1e200, 1e300, 1.7e308}) {
        const MeshDistance found = apart(1.0, x);
        EXPECT_DOUBLE_EQ(found.distance, x);
        EXPECT_EQ(std::abs(found.point_a.x()), 1.0); // any pair will do
        EXPECT_DOUBLE_EQ(found.point_b.x(), x);
    }
    for (const double size : {1e-100, 1e-160, 1e-200, 1e-300, 1e-307}) {
        const MeshDistance found = apart(size, 3 * size);
        EXPECT_NEAR(found.distance, size, 1e-15 * size);
        EXPECT_EQ(found.point_a.x(), size);
        EXPECT_NEAR(found.point_b.x(), 2 * size, 1e-15 * size);
        EXPECT_EQ(apart(size, 2 * size).distance, 0);
        EXPECT_EQ(apart(size, 1.0).distance, 1.0);
    }
    // Apart by the least there is.
    const double least = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(apart(1e-310, 2e-310 + least).distance, least);
    EXPECT_EQ(apart(1e-310, 2e-310).distance, 0);
    EXPECT_EQ(apart(1e-310, -3e-310).distance, 1e-310);
}

// Found by a fuzzer: the square of such a triangle's normal has few digits in lanes of floats.
TEST(MeshDistance, SeesTrianglesThatAreTinyBesideTheMesh)
{
    const MeshIndex b = index_of(
        mesh_of({Vec3(-5.7835888720200663e+18, -3.9943665323343299e+18, 4.7969926155324027e+18),
                 Vec3(1.2663154102177858e+19, -3.9943665323344399e+18, 4.7969926155320801e+18)},
                {{0, 1, 1}}));
    for (int i = 0; i <= 200; ++i) {
        const double size = (0.75 + i / 400.0) * 1.8446742974197923e+19;
        const TriangleMesh a =
            mesh_of({Vec3(283545150947328, -16189709, -9.6135693183896365e-07),
                     Vec3(6213342208, 0.30673310160636902, 334.11782836914062),
                     Vec3(4.0280956454807892e-06, 5.7251175280599874e-17, 0.2561434805393219),
                     Vec3(-size, size, -size), Vec3(size, size, -size), Vec3(0, size, -size)},
                    {{0, 1, 2}, {3, 4, 5}});
        const auto nearest = mesh_distance(index_of(a), b, {});
        ASSERT_TRUE(nearest && nearest->triangle_a == TriangleId{0});
        const auto found = mesh_distance(index_of(a), b, {}, {.farthest = nearest->distance});
        EXPECT_TRUE(found && found->distance == nearest->distance) << size;
    }
}

TEST(MeshDistance, OfAPointIsRightAtAnyScale)
{
    const Vec3 corners[3] = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0.125)};
    for (const int exponent : {-1000, -600, -520, -515, -510, -300, 0, 300, 510, 900}) {
        const double unit = std::ldexp(1.0, exponent);
        const auto point_at = [&](const Vec3& p) {
            return index_of(mesh_of_points({p * unit}).value());
        };
        const MeshIndex triangle = index_of(testing::mesh_of(
            {corners[0] * unit, corners[1] * unit, corners[2] * unit}, {{0, 1, 2}}));
        const MeshIndex a = point_at(Vec3(0.25, 0.25, 1.03125));
        const MeshIndex b = point_at(Vec3(0.25, -2.75, -2.96875));
        RigidTransform moved;
        moved.translation = Vec3(0, 0, -3 * unit);
        const auto distance = [&](const MeshIndex& from, const MeshIndex& to,
                                  const RigidTransform& pose = {}) {
            return mesh_distance(from, to, pose).value().distance / unit;
        };
        // Above the triangle, whose plane is z = y / 8, by 1.
        const double along_normal = 1 / std::sqrt(1 + 1.0 / 64);
        EXPECT_NEAR(distance(a, triangle), along_normal, 1e-15) << exponent;
        EXPECT_NEAR(distance(triangle, a), along_normal, 1e-15) << exponent;
        EXPECT_EQ(distance(a, b), 5) << exponent;
        EXPECT_EQ(distance(b, a), 5) << exponent;
        EXPECT_EQ(distance(a, a, moved), 3) << exponent;
        EXPECT_EQ(distance(a, a), 0) << exponent;
        EXPECT_FALSE(mesh_distance(a, b, {}, {.farthest = 4.99 * unit})) << exponent;
        EXPECT_TRUE(mesh_distance(a, b, {}, {.farthest = 5.01 * unit})) << exponent;
    }
}

TEST(MeshDistance, IsNeverZeroApartHoweverNear)
{
    for (const double size : {1.0, 1e100, 1e150, 1e300}) {
        for (const double height : {1.0, 1e-100, 1e-200, 1e-300, 5e-324}) {
            SCOPED_TRACE(::testing::Message() << "size " << size << " height " << height);
            const MeshIndex floor = index_of(testing::mesh_of(
                {Vec3(-size, -size, 0), Vec3(size, -size, 0), Vec3(0, size, 0)}, {{0, 1, 2}}));
            const MeshIndex point = index_of(testing::mesh_of({Vec3(0, 0, height)}, {{0, 0, 0}}));
            const auto found = mesh_distance(floor, point);
            ASSERT_TRUE(found);
            EXPECT_GT(found->distance, 0);
            EXPECT_LE(found->distance, height + 1e-15 * size); // a few roundings of coordinates
            EXPECT_GT(mesh_distance(point, floor)->distance, 0);
        }
    }
}

TEST(MeshDistance, IsZeroWhereMeshesTouchBesideTrianglesThatAreAllButTouching)
{
    // The first triangles are 1e-200 apart: in units of these meshes that is 0.
    const double far = 1e250;
    const auto mesh = [&](double height, double top) {
        return testing::mesh_of({Vec3(0, 0, height), Vec3(1, 0, height), Vec3(0, 1, height + top),
                                 Vec3(3 * far, 0, 0), Vec3(4 * far, 0, 0),
                                 Vec3(3 * far, far, top * far)},
                                {{0, 1, 2}, {3, 4, 5}});
    };
    const MeshIndex a = index_of(mesh(0, 0));
    const MeshIndex b = index_of(mesh(1e-200, 1));
    for (const auto& found : {mesh_distance(a, b), mesh_distance(b, a)}) {
        ASSERT_TRUE(found);
        EXPECT_EQ(found->distance, 0);
        EXPECT_EQ(found->triangle_a, TriangleId{1});
        EXPECT_EQ(found->triangle_b, TriangleId{1});
    }
}

TEST(MeshDistance, FindsNothingForAnEmptyMesh)
{
    const MeshIndex cube = index_of(cube_mesh(Vec3::Zero(), 1.0));
    EXPECT_FALSE(mesh_distance(cube, MeshIndex()));
    EXPECT_FALSE(mesh_distance(MeshIndex(), cube));
    EXPECT_FALSE(
        mesh_distance(cube, cube, {}, {.farthest = std::numeric_limits<double>::quiet_NaN()}));
}

TEST(MeshDistance, FindsNothingOnceCancelled)
{
    const MeshIndex torus = index_of(torus_mesh(1.0, 0.4, 40, 20));
    const RigidTransform apart = {.translation = Vec3(5, 0, 0)};
    Progress progress;
    EXPECT_TRUE(mesh_distance(torus, torus, apart, {.progress = &progress}));
    progress.cancel();
    EXPECT_FALSE(mesh_distance(torus, torus, apart, {.progress = &progress}));
}

} // namespace
} // namespace proxima::mesh_distance_test
