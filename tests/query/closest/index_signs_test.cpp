// Signs of distances that the mesh index finds, against exact crossings of a line on closed
// meshes and sums of solid angles on open ones.
#include "index/listed_index.h"
#include "index/test_meshes.h"
#include "octree/small_meshes.h"
#include "octree/winding_number.h"
#include "oracles/column_winding.h"
#include "proxima/signed_distance.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>

namespace proxima::index_signs_test {
namespace {

using namespace testing;

/// Asks the signs of points; `is_inside` may not know some.
void expect_signs(const TriangleMesh& mesh, int count, unsigned seed,
                  const std::function<std::optional<bool>(const Vec3&)>& is_inside)
{
    const auto index = testing::listed_index(mesh).and_then(
        [](const MeshIndex& listed) { return with_signs(listed); });
    ASSERT_TRUE(index);
    const Box box = bounding_box(mesh);
    const double size = box.extent().norm() + box.center().norm();
    int inside = 0;
    int outside = 0;
    for (const Vec3& p : proximity_points(mesh, count, seed)) {
        const SignedDistance found = signed_distance(*index, p).value();
        if (std::abs(found.distance) < 1e-14 * (size + p.norm())) continue; // either side will do
        const auto truth = is_inside(p);
        if (!truth) continue;
        EXPECT_EQ(found.distance < 0, *truth)
            << "point " << p.transpose() << " distance " << found.distance << " by "
            << name_of(found.method) << ", seed " << seed;
        ++(*truth ? inside : outside);
    }
    EXPECT_GT(inside, count / 100);
    EXPECT_GT(outside, count / 3);
}

TEST(IndexSigns, OfClosedMeshesAgreeWithExactCrossings)
{
    const TriangleMesh inner =
        moved(make_sphere(16, 20), [](const Vec3& p) { return Vec3(p / 2); });
    const std::vector<NamedMesh> meshes = {
        {"cube", make_cube()},
        {"octahedron", make_octahedron()},
        {"sphere", make_sphere(30, 40)},
        {"icosphere", make_icosphere(3)},
        {"torus", make_torus(48, 24)},
        {"spaceship", sample_mesh("spaceship:2000").value()},
        {"nested spheres", joined(make_sphere(20, 30), inner)},
        {"a shell", joined(make_sphere(20, 30), inverted(inner))}};
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const oracle::ColumnWinding columns(named.mesh);
        expect_signs(named.mesh, 2000, 41, [&](const Vec3& p) -> std::optional<bool> {
            const auto winding = columns.at(p);
            if (!winding) return std::nullopt;
            return *winding >= 1;
        });
    }
}

TEST(IndexSigns, OfOpenMeshesAgreeWithTheWindingNumber)
{
    const std::vector<NamedMesh> meshes = {
        {"sphere with a lid off",
         without(make_sphere(20, 30), [](std::size_t i) { return i < 90; })},
        {"sphere with holes",
         without(make_sphere(20, 30), [](std::size_t i) { return i % 9 == 0; })},
        {"torus with a slit", without(make_torus(30, 20), [](std::size_t i) { return i < 20; })}};
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        expect_signs(named.mesh, 1500, 42, [&](const Vec3& p) -> std::optional<bool> {
            const double winding = brute_winding_number(named.mesh, p);
            if (std::abs(winding - 0.5) < 1e-9) return std::nullopt;
            return winding > 0.5;
        });
    }
}

TEST(ColumnWinding, AgreesWithExactWindingNumbers)
{
    const TriangleMesh mesh = joined(make_torus(12, 8), inverted(make_sphere(8, 9)));
    const oracle::ColumnWinding columns(mesh);
    int inside = 0;
    for (const Vec3& p : proximity_points(mesh, 600, 43)) {
        const auto one = columns.at(p);
        const auto other = oracle::exact_winding(mesh, p);
        if (one && other) {
            EXPECT_EQ(*one, *other) << p.transpose();
        }
        if (one && *one != 0) ++inside;
    }
    EXPECT_GT(inside, 50);
}

} // namespace
} // namespace proxima::index_signs_test
