#include "proxima/intersect_meshes.h"

#include "cancellation.h"
#include "code_of.h"
#include "counted_allocations.h"
#include "octree/small_meshes.h"
#include "octree/winding_number.h"
#include "oracles/column_winding.h"
#include "proxima/sample_meshes.h"
#include "query/contact/enclosure_parts.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::containment_test {
namespace {

using namespace testing;

constexpr Containment none = Containment::none;
constexpr Containment a_in_b = Containment::a_in_b;
constexpr Containment b_in_a = Containment::b_in_a;

RigidTransform shifted(const Vec3& by)
{
    return {.translation = by};
}

Enclosure enclosure_of(const TriangleMesh& mesh)
{
    return build_enclosure(build_mesh_index(mesh).value()).value();
}

/// How A and B lie. Also checks that signs of B do not change the answer.
ContainmentAnswer ask(const TriangleMesh& a, const TriangleMesh& b, const RigidTransform& pose = {})
{
    const ContainmentAnswer answer = find_containment(enclosure_of(a), enclosure_of(b), pose);
    const MeshIndex with = with_signs(build_mesh_index(b).value()).value();
    const ContainmentAnswer same =
        find_containment(enclosure_of(a), build_enclosure(with).value(), pose);
    EXPECT_EQ(same.containment, answer.containment);
    EXPECT_EQ(same.method, answer.method);
    return answer;
}

TriangleMesh ball(double radius, const Vec3& center = Vec3::Zero())
{
    return sphere_mesh(center, radius, 8, 9);
}

TEST(Containment, FindsWhichOfTwoBallsIsInside)
{
    const RigidTransform turned = {Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).matrix(),
                                   Vec3(0.25, 0.25, 0)};
    EXPECT_EQ(ask(ball(1), ball(2), turned).containment, a_in_b);
    EXPECT_EQ(ask(ball(2), ball(1), turned).containment, b_in_a);
    EXPECT_EQ(ask(ball(1), ball(2), shifted(Vec3(4, 0, 0))).containment, none);
    // In the bounds of a torus, and not inside of it.
    EXPECT_EQ(ask(ball(0.2), torus_mesh(1, 0.4, 20, 12)).containment, none);
    EXPECT_EQ(ask(ball(0.2), torus_mesh(1, 0.4, 20, 12), shifted(Vec3(1, 0, 0))).containment,
              a_in_b);
    EXPECT_EQ(ask(ball(1), ball(2)).method, InsideMethod::crossings);
}

TEST(Containment, ChecksEveryPartOfTheInnerMesh)
{
    const TriangleMesh two = joined(ball(0.3), ball(0.3, Vec3(3, 0, 0)));
    EXPECT_EQ(enclosure_of(two).parts().vertices.size(), 2U);
    EXPECT_EQ(ask(two, ball(2)).containment, none);
    EXPECT_EQ(ask(two, ball(4)).containment, a_in_b);
    // Parts of the outer mesh: a cavity is outside, where parts overlap is inside.
    const TriangleMesh hollow = joined(ball(2), inverted(ball(1)));
    EXPECT_EQ(ask(ball(0.5), hollow).containment, none);
    EXPECT_EQ(ask(ball(0.3, Vec3(1.5, 0, 0)), hollow).containment, a_in_b);
    const TriangleMesh overlapping = joined(ball(2), ball(2, Vec3(2, 0, 0)));
    EXPECT_EQ(ask(ball(0.3, Vec3(1, 0, 0)), overlapping).containment, a_in_b);
}

TEST(Containment, UsesAMethodThatFitsTheMesh)
{
    const ContainmentAnswer inside_out = ask(ball(1), inverted(ball(2)));
    EXPECT_EQ(inside_out.containment, a_in_b);
    EXPECT_EQ(inside_out.method, InsideMethod::crossings);

    const TriangleMesh outer = ball(2);
    std::vector<Vec3> positions(outer.positions().begin(), outer.positions().end());
    std::vector<TriangleCorners> triangles(outer.triangles().begin(), outer.triangles().end());
    std::swap(triangles[10][0], triangles[10][1]);
    const TriangleMesh one_flipped = mesh_of(positions, triangles);
    const ContainmentAnswer by_parity = ask(ball(1), one_flipped);
    EXPECT_EQ(by_parity.containment, a_in_b);
    EXPECT_EQ(by_parity.method, InsideMethod::parity);

    const TriangleMesh open = without(outer, [](std::size_t i) { return i < 3; });
    const ContainmentAnswer by_winding = ask(ball(1), open);
    EXPECT_EQ(by_winding.containment, a_in_b);
    EXPECT_EQ(by_winding.method, InsideMethod::winding_number);
    EXPECT_EQ(ask(ball(1), inverted(open)).containment, a_in_b);
    EXPECT_EQ(ask(open, ball(1)).containment, b_in_a);
    const ContainmentAnswer apart = ask(open, ball(1), shifted(Vec3(4, 0, 0)));
    EXPECT_EQ(apart.containment, none);
    EXPECT_EQ(apart.method, InsideMethod::winding_number); // the less certain of the two
    EXPECT_EQ(ask(ball(1), open, shifted(Vec3(4, 0, 0))).method, InsideMethod::winding_number);

    // Every triangle with vertices of its own: still closed.
    positions.clear();
    triangles.clear();
    for (const TriangleCorners& corners : outer.triangles()) {
        const auto next = static_cast<std::uint32_t>(positions.size());
        for (const std::uint32_t corner : corners) positions.push_back(outer.positions()[corner]);
        triangles.push_back({next, next + 1, next + 2});
    }
    EXPECT_EQ(ask(ball(1), mesh_of(positions, triangles)).method, InsideMethod::crossings);
    EXPECT_FALSE(build_enclosure(MeshIndex()));
}

/// Sheets one above the other wind about points that are beyond all of them: what is far away, and only widens the box, changes nothing.
TEST(Containment, OfOpenMeshesGoesBeyondTheirBox)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (const double height : {0.0, 0.01, 0.02}) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const Vec3& p : {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)})
            positions.push_back(p + Vec3(0, 0, height));
        triangles.push_back({first, first + 2, first + 1});
        triangles.push_back({first, first + 3, first + 2});
    }
    const Vec3 above(0.1, 0.2, 0.03);
    const TriangleMesh sheets = mesh_of(positions, triangles);
    EXPECT_GT(std::abs(brute_winding_number(sheets, above)), 1.4);
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const Vec3& p : {Vec3(0, 0, 5), Vec3(0.001, 0, 5), Vec3(0, 0.001, 5)})
        positions.push_back(p);
    triangles.push_back({first, first + 1, first + 2});
    for (const TriangleMesh& mesh : {sheets, mesh_of(positions, triangles)}) {
        const Enclosure enclosure = enclosure_of(mesh);
        EXPECT_EQ(enclosure.method(), InsideMethod::winding_number);
        EXPECT_TRUE(encloses(enclosure, {}, above));
        EXPECT_FALSE(encloses(enclosure, {}, Vec3(0.1, 0.2, 3)));
        EXPECT_FALSE(encloses(enclosure, {}, Vec3(5, 0, 0.01)));
    }
}

/// Points in line with corners and edges, where a careless count of crossings is wrong.
TEST(Containment, CountsCrossingsExactly)
{
    constexpr std::uint32_t seed = 3;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const auto on_grid = [](const TriangleMesh& mesh) {
        return moved(mesh, [](const Vec3& p) { return Vec3((4 * p).array().round() / 4); });
    };
    const std::vector<TriangleMesh> meshes = {
        on_grid(torus_mesh(1, 0.5, 13, 8)), on_grid(make_icosphere(2)), make_octahedron(),
        joined(make_cube(), cube_mesh(Vec3(1, 1, 0), 1)), make_cube()};
    Mat3 quarter;
    quarter << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    int inside = 0;
    int outside = 0;
    for (const TriangleMesh& mesh : meshes) {
        const RigidTransform pose = {quarter, Vec3(0.25, -0.5, 1)};
        const Enclosure enclosure = enclosure_of(mesh);
        EXPECT_EQ(enclosure.method(), InsideMethod::crossings);
        const oracle::ColumnWinding truth(mesh);
        for (int i = 0; i < 3000; ++i) {
            const auto coordinate = [&] {
                return std::ldexp(static_cast<double>(random() % 33) - 16, i % 2 == 0 ? -2 : -3);
            };
            const double x = coordinate();
            const double y = coordinate();
            const Vec3 point(x, y, coordinate());
            const auto windings = truth.at(point);
            if (!windings) continue; // on the surface
            ASSERT_EQ(encloses(enclosure, {}, point), *windings != 0) << point.transpose();
            ASSERT_EQ(encloses(enclosure, pose, pose(point)), *windings != 0);
            ++(*windings != 0 ? inside : outside);
        }
    }
    EXPECT_GT(inside, 500);
    EXPECT_GT(outside, 500);
}

/// Points from which the ray along x goes exactly through moved corners and middles of sides.
TEST(Containment, AgreesWithWindingNumbersInAnyPose)
{
    constexpr std::uint32_t seed = 11;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const TriangleMesh torus = torus_mesh(1, 0.5, 21, 12);
    const auto placed = [&](double scale, const Vec3& offset) {
        return moved(torus, [&](const Vec3& p) { return Vec3(scale * p + offset); });
    };
    const std::vector<TriangleMesh> meshes = {
        torus,
        joined(ball(2), inverted(ball(1))),
        joined(ball(2), ball(2, Vec3(2, 0, 0))),
        moved(torus, [](const Vec3& p) { return Vec3(p.x(), 1e-3 * p.y(), 40 * p.z()); }),
        placed(1, Vec3(1e6, -2e6, 3e5)),
        placed(1e-30, Vec3::Zero()),
        placed(1e30, Vec3(0, 1e31, 0)),
        placed(1e304, Vec3::Zero())};
    int inside = 0;
    int outside = 0;
    for (const TriangleMesh& mesh : meshes) {
        const Enclosure enclosure = enclosure_of(mesh);
        const double extent = bounding_box(mesh).extent().maxCoeff();
        for (int turn = 0; turn < 6; ++turn) {
            const Vec3 axis = Vec3(uniform(random), uniform(random), uniform(random)).normalized();
            const RigidTransform pose = {
                Eigen::AngleAxisd(4 * uniform(random), axis).matrix(),
                extent * Vec3(uniform(random), uniform(random), uniform(random))};
            const TriangleMesh there = moved(mesh, [&](const Vec3& p) { return pose(p); });
            for (int i = 0; i < 100; ++i) {
                const Triangle triangle = there.triangle(
                    TriangleId{static_cast<std::uint32_t>(random() % there.triangle_count())});
                const Vec3 on_ray =
                    i % 2 == 0 ? triangle[0] : Vec3(0.5 * (triangle[1] + triangle[2]));
                const Vec3 point = on_ray - Vec3(extent * uniform(random), 0, 0);
                const double winding = brute_winding_number(there, point);
                if (std::abs(winding - std::round(winding)) > 1e-3) continue; // on the surface
                const bool is_inside = std::abs(std::round(winding)) > 0;
                ASSERT_EQ(encloses(enclosure, pose, point), is_inside) << point.transpose();
                ++(is_inside ? inside : outside);
            }
        }
    }
    EXPECT_GT(inside, 500);
    EXPECT_GT(outside, 500);
}

TEST(Containment, AllocatesNothingAndCanBeCancelled)
{
    const TriangleMesh inner = ball(1);
    const TriangleMesh outer = ball(2);
    const TriangleMesh open = without(outer, [](std::size_t i) { return i == 3; });
    const Enclosure a = enclosure_of(inner);
    const Enclosure b = enclosure_of(outer);
    const Enclosure c = enclosure_of(open);
    const std::size_t before = allocation_count();
    EXPECT_EQ(find_containment(a, b).containment, a_in_b);
    EXPECT_EQ(find_containment(a, c).containment, a_in_b);
    EXPECT_EQ(allocation_count(), before);
    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(build_enclosure(build_mesh_index(open).value(),
                                      {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::containment_test
