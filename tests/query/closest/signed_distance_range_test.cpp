// Signs far from a mesh, about parts of it of any size, and of what is no point.
#include "base/text.h"
#include "oracles/exact_winding.h"
#include "proxima/neighbourhood.h"
#include "query/closest/brute_force.h"
#include "query/closest/signed_mesh.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace proxima::signed_distance_range_test {
namespace {

using namespace testing;

/// A closed tetrahedron of three right angles at the corner.
TriangleMesh corner_tetrahedron(const Vec3& corner, double size)
{
    return mesh_of({corner, corner + size * Vec3::UnitX(), corner + size * Vec3::UnitY(),
                    corner + size * Vec3::UnitZ()},
                   {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

/// A closed box of two extents and a thickness.
TriangleMesh sheet(const Vec3& middle, double half, double thickness)
{
    return moved(cube_mesh(Vec3::Zero(), 1.0), [&](const Vec3& p) {
        return Vec3(middle + Vec3(half * p.x(), half * p.y(), thickness * (p.z() > 0 ? 1 : 0)));
    });
}

std::vector<Vec3> random_directions(int count, unsigned seed)
{
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<Vec3> directions = {Vec3(1, 1, 1), Vec3(-1, 1, 1), Vec3(0, 0, 1), Vec3(1, -1, 0)};
    for (int i = 0; i < count; ++i)
        directions.push_back(Vec3{normal(random), normal(random), normal(random)});
    for (Vec3& direction : directions) direction.normalize();
    return directions;
}

TEST(SignedDistance, IsPositiveAtAnyDistanceFromAClosedMesh)
{
    const std::vector<NamedMesh> meshes = {
        {"cube", cube_mesh(Vec3::Zero(), 1.0)},
        {"tiny tetrahedron", corner_tetrahedron(Vec3::Zero(), 1e-30)},
        {"knife", knife(0.05)},
        {"torus", torus_mesh(1.0, 0.3, 20, 10)},
        {"ball", ball(Vec3(1, 2, 3), 1e-3)},
        {"shell", joined(ball(Vec3::Zero(), 1.0), inverted(ball(Vec3::Zero(), 0.5)))}};
    constexpr unsigned seed = 51;
    const std::vector<Vec3> directions = random_directions(20, seed);
    for (const NamedMesh& named : meshes) {
        const Signed of(named.mesh);
        const Box box = bounding_box(named.mesh);
        for (int power = 1; power <= 150; power += power < 20 ? 1 : 5) {
            for (const Vec3& direction : directions) {
                const Vec3 p =
                    box.center() + std::pow(10.0, power) * box.extent().norm() * direction;
                const SignedDistance found = of.at(p);
                ASSERT_GT(found.distance, 0)
                    << named.name << ", 1e" << power << " sizes along " << direction.transpose()
                    << " by " << name_of(found.method) << ", seed " << seed;
                if (power > 40 || named.mesh.triangle_count() > 50) continue;
                ASSERT_EQ(oracle::exact_winding(named.mesh, p), 0);
            }
        }
    }
}

TEST(SignedDistance, IsExactForPartsOfAnySizeInAMesh)
{
    const TriangleMesh whole = ball(Vec3::Zero(), 1.0);
    constexpr unsigned seed = 52;
    const std::vector<Vec3> directions = random_directions(12, seed);
    int inside = 0;
    int outside = 0;
    for (int power = 0; power <= 40; power += power < 20 ? 2 : 5) {
        const double size = 0.1 * std::pow(10.0, -power);
        for (const NamedMesh& named : std::vector<NamedMesh>{
                 {"pit", joined(whole, inverted(corner_tetrahedron(Vec3::Zero(), size)))},
                 {"grain", joined(whole, corner_tetrahedron(Vec3::Zero(), size))},
                 {"beside",
                  joined(ball(Vec3(4, 0, 0), 1.0), corner_tetrahedron(Vec3::Zero(), size))},
                 {"sheet", joined(ball(Vec3(0, 0, 9), 1.0), sheet(Vec3::Zero(), 1.0, size))},
                 {"slit", joined(whole, inverted(sheet(Vec3::Zero(), 0.3, size)))}}) {
            const Signed of(named.mesh);
            const bool thin = named.name == "sheet" || named.name == "slit";
            for (int reach = 0; reach <= power + 1; ++reach) {
                for (const Vec3& direction : directions) {
                    const Vec3 p = 5 * size * std::pow(10.0, reach) * direction;
                    const SignedDistance found = of.at(p);
                    const auto winding = oracle::exact_winding(named.mesh, p);
                    if (!winding || found.distance == 0) continue;
                    // As near to a large triangle either side will do.
                    if (thin && std::abs(found.distance) < 1e-14) continue;
                    ASSERT_EQ(found.distance < 0, *winding >= 1)
                        << named.name << " of size 1e-" << power + 1 << " at " << p.transpose()
                        << " by " << name_of(found.method) << ", seed " << seed;
                    ++(*winding >= 1 ? inside : outside);
                }
            }
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(outside, 1000);
}

/// A triangle about as large as `size`, so far away.
TriangleMesh far_triangle(double far, double size)
{
    return mesh_of({Vec3(far, 0, 0), Vec3(far, size, 0), Vec3(far, 0, size)}, {{0, 1, 2}});
}

TEST(SignedDistance, IsThatOfAPartHoweverFarTheRestIs)
{
    constexpr unsigned seed = 53;
    const std::vector<Vec3> directions = random_directions(20, seed);
    for (const double size : {1.0, 1e-30}) {
        const TriangleMesh part =
            moved(ball(Vec3::Zero(), 1.0), [&](const Vec3& p) { return Vec3(size * p); });
        const Signed alone(part);
        for (int power = 2; power + (size < 1 ? 30 : 0) <= 125; power += 7) {
            const double far = std::pow(10.0, power);
            if (far > 1e100) break;
            for (const double wide : {size, far}) {
                const TriangleMesh mesh = joined(part, far_triangle(far, wide));
                const Signed of(mesh);
                const Topology topology = build_topology(mesh).value();
                const MeshIndex before =
                    build_mesh_index(joined(part, far_triangle(far / 8, wide))).value();
                const MeshIndex moved_there =
                    with_signs(refit_index(before, mesh, topology).value()).value();
                for (const Vec3& direction : directions) {
                    for (const double reach : {0.1, 0.9, 0.99, 1.01, 1.5, 20.0}) {
                        const Vec3 p = reach * size * direction;
                        const SignedDistance expected = alone.at(p);
                        const std::string where =
                            concat("a part of ", size, " and a triangle ", far, " away, reach ",
                                   reach, ", seed ", seed);
                        for (const MeshIndex& index : {of.index, moved_there}) {
                            const SignedDistance found = signed_distance(index, p).value();
                            ASSERT_NEAR(found.distance, expected.distance, 1e-13 * size) << where;
                            ASSERT_EQ(found.closest.feature.kind, expected.closest.feature.kind)
                                << where;
                        }
                        const ClosestFeature slow =
                            closest_feature_by_brute_force(mesh, topology, p);
                        ASSERT_NEAR(std::sqrt(slow.squared_distance), std::abs(expected.distance),
                                    1e-13 * size)
                            << where;
                    }
                }
            }
        }
    }
}

TEST(SignedDistance, IsNothingForPointsThatAreNotFinite)
{
    const Signed of(ball(Vec3::Zero(), 1.0));
    const Topology topology = build_topology(of.mesh).value();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const Vec3& p : {Vec3(nan, 0, 0), Vec3(0, 0.5, nan), Vec3(nan, nan, nan),
                          Vec3(infinity, 0, 0), Vec3(0, -infinity, 0)}) {
        EXPECT_FALSE(closest_feature(of.index, p));
        EXPECT_FALSE(signed_distance(of.index, p));
        EXPECT_FALSE(closest_feature(of.index, p, {.radius = 9.0}));
        EXPECT_FALSE(is_found(closest_feature_by_brute_force(of.mesh, topology, p)));
    }
    EXPECT_FALSE(closest_feature(of.index, Vec3::Zero(), {.radius = -1.0}));
    EXPECT_FALSE(closest_feature(of.index, Vec3::Zero(), {.radius = nan}));
    std::vector<TriangleId> buffer(500);
    EXPECT_EQ(collect_triangles(of.index, Vec3::Zero(), -1.0, buffer).written, 0U);
    EXPECT_EQ(collect_triangles(of.index, Vec3::Zero(), nan, buffer).written, 0U);
    EXPECT_EQ(collect_triangles(of.index, Vec3(nan, 0, 0), 9.0, buffer).written, 0U);
}

} // namespace
} // namespace proxima::signed_distance_range_test
