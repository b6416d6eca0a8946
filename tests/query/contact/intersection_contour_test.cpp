#include "proxima/intersect_meshes.h"

#include "geometry/closest_point.h"
#include "geometry/triangle_intersection.h"
#include "octree/small_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "query/contact/join_segments.h"
#include "query/contact/test_poses.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

namespace proxima::intersection_contour_test {
namespace {

using namespace testing;

RigidTransform shifted(const Vec3& by)
{
    return {.translation = by};
}

double distance_to(const TriangleMesh& mesh, const RigidTransform& pose, const Vec3& point)
{
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const Triangle triangle = pose(mesh.triangle(TriangleId{id}));
        least = std::min(least, (closest_point(triangle, point).point - point).norm());
    }
    return least;
}

void expect_same(const IntersectionContour& found, const IntersectionContour& expected)
{
    const auto same_point = [](const ContourPoint& p, const ContourPoint& q) {
        return p.position == q.position && p.on_a == q.on_a && p.on_b == q.on_b;
    };
    const auto same_line = [](const ContourLine& p, const ContourLine& q) {
        return p.first == q.first && p.count == q.count && p.closed == q.closed;
    };
    EXPECT_TRUE(std::ranges::equal(found.points, expected.points, same_point));
    EXPECT_TRUE(std::ranges::equal(found.lines, expected.lines, same_line));
}

/// All of its points lie on both surfaces, by rounding.
IntersectionContour contour_of(const TriangleMesh& a, const TriangleMesh& b,
                               const RigidTransform& pose)
{
    IntersectionContour contour =
        intersection_contour(a, b, pose, pairs_by_brute_force(a, b, pose));
    expect_same(
        intersection_contour(build_mesh_index(a).value(), build_mesh_index(b).value(), pose),
        contour);
    double size = 0;
    for (const TriangleMesh* mesh : {&a, &b}) {
        const Box box = bounding_box(*mesh);
        size = std::max({size, box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff()});
    }
    size += pose.translation.norm();
    for (std::size_t i = 0; i < contour.points.size(); i += 1 + contour.points.size() / 100) {
        EXPECT_LT(distance_to(a, {}, contour.points[i].position), 1e-14 * size);
        EXPECT_LT(distance_to(b, pose, contour.points[i].position), 1e-14 * size);
    }
    std::size_t next = 0;
    for (const ContourLine& line : contour.lines) {
        EXPECT_EQ(line.first, next);
        EXPECT_GT(line.count, line.closed ? 2U : 0U);
        next += line.count;
    }
    EXPECT_EQ(next, contour.points.size());
    return contour;
}

std::size_t closed_lines(const IntersectionContour& contour)
{
    return static_cast<std::size_t>(std::ranges::count_if(contour.lines, &ContourLine::closed));
}

TEST(IntersectionContour, OfTwoSpheresIsACircle)
{
    const TriangleMesh sphere = make_icosphere(4);
    const RigidTransform pose = {Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).matrix(),
                                 Vec3(1, 0, 0)};
    const IntersectionContour contour = contour_of(sphere, sphere, pose);
    ASSERT_EQ(contour.lines.size(), 1U);
    EXPECT_TRUE(contour.lines[0].closed);
    // A point of both lies below either sphere, by no more than their faces: x is off by as much at
    // most, and the distance from the axis by that over the circle's radius.
    const double radius = std::sqrt(0.75);
    const double below = 1 - inner_radius(sphere);
    const double off = 1.01 * below / radius;
    for (const ContourPoint& point : contour.points) {
        EXPECT_NEAR(point.position.x(), 0.5, 1.01 * below);
        EXPECT_NEAR(std::hypot(point.position.y(), point.position.z()), radius, off);
    }
    EXPECT_NEAR(contour.length(), 2 * std::numbers::pi * radius, 2 * std::numbers::pi * off);
}

TEST(IntersectionContour, OfCubeAndSphereIsSixCircles)
{
    const TriangleMesh sphere = moved(make_icosphere(4), [](const Vec3& p) { return 1.2 * p; });
    const RigidTransform pose = {Eigen::AngleAxisd(1, Vec3(3, 1, 2).normalized()).matrix(),
                                 Vec3::Zero()};
    const IntersectionContour contour = contour_of(make_cube(), sphere, pose);
    EXPECT_EQ(contour.lines.size(), 6U);
    EXPECT_EQ(closed_lines(contour), 6U);
    // Each of six is a convex polygon between the circles in which a face of the cube cuts the
    // sphere and the largest ball within it.
    const double inner = inner_radius(sphere);
    EXPECT_LT(contour.length(), 6 * 2 * std::numbers::pi * std::sqrt(1.2 * 1.2 - 1));
    EXPECT_GT(contour.length(), 6 * 2 * std::numbers::pi * std::sqrt(inner * inner - 1));
}

/// In general position every pair has its own segment, so that lengths add up.
TEST(IntersectionContour, OfClosedMeshesIsClosedAndHasEverySegment)
{
    constexpr std::uint64_t seed = 21;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const TriangleMesh a = torus_mesh(1.0, 0.4, 24, 16);
    const TriangleMesh b = sphere_mesh(Vec3(0.3, 0.2, 0.1), 0.8, 12, 16);
    std::mt19937_64 random(seed);
    const auto number = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    std::size_t closed = 0;
    for (int i = 0; i < 60; ++i) {
        const RigidTransform pose = {
            Eigen::AngleAxisd(number(), Vec3{number(), number(), number()}.normalized()).matrix(),
            Vec3{number(), number(), number()}};
        const auto pairs = pairs_by_brute_force(a, b, pose);
        const IntersectionContour contour = contour_of(a, b, pose);
        EXPECT_EQ(closed_lines(contour), contour.lines.size()) << "pose " << i;
        closed += contour.lines.size();
        double length = 0;
        for (const TrianglePair& pair : pairs) {
            const Triangle s = a.triangle(pair.a);
            const Triangle t = pose(b.triangle(pair.b));
            const TriangleIntersection ends = intersect(s, t);
            ASSERT_EQ(ends.size(), 2U);
            length +=
                (meeting_point(s, t, ends.ends()[0]) - meeting_point(s, t, ends.ends()[1])).norm();
        }
        EXPECT_NEAR(contour.length(), length, 1e-12 * (1 + length));
        EXPECT_EQ(contour.points.size(), pairs.size());
    }
    EXPECT_GT(closed, 60U);
}

/// Coordinates on a coarse grid, turned by quarters: corners on edges, edges on edges, faces in one
/// plane. Where meshes pass through each other, lines stay closed; where they touch they may end.
TEST(IntersectionContour, StaysOnBothSurfacesInDegeneratePositions)
{
    constexpr std::uint64_t seed = 22;
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const auto coarse = [](const TriangleMesh& mesh) {
        return moved(mesh, [](const Vec3& p) { return Vec3((4 * p).array().round() / 4); });
    };
    const std::vector<TriangleMesh> meshes = {coarse(torus_mesh(1.5, 0.75, 12, 8)),
                                              coarse(make_icosphere(2)), make_cube(),
                                              make_octahedron()};
    std::size_t points = 0;
    for (const TriangleMesh& a : meshes) {
        for (const TriangleMesh& b : meshes) {
            PoseGenerator generate(a, b, seed);
            for (int i = 0; i < 20; ++i) {
                const RigidTransform pose = generate();
                const auto contour = contour_of(a, b, pose);
                EXPECT_EQ(contour.points.empty(), pairs_by_brute_force(a, b, pose).empty());
                points += contour.points.size();
                if (HasFailure()) return;
            }
        }
    }
    EXPECT_GT(points, 5000U);
}

TEST(IntersectionContour, OfCoplanarFacesIsTheBorderOfTheirOverlap)
{
    const TriangleMesh cube = make_cube();
    // A square of one side, shared in part with the face above it.
    const IntersectionContour on_top = contour_of(cube, cube, shifted(Vec3(1, 0.5, 2)));
    ASSERT_EQ(on_top.lines.size(), 1U);
    EXPECT_TRUE(on_top.lines[0].closed);
    EXPECT_EQ(on_top.length(), 2 * (1 + 1.5));
    for (const ContourPoint& point : on_top.points) EXPECT_EQ(point.position.z(), 1);
    // Two cubes shifted along x share four faces in part: two rings, and the edges between them.
    const IntersectionContour shared = contour_of(cube, cube, shifted(Vec3(1, 0, 0)));
    EXPECT_EQ(shared.length(), 2 * 8 + 4 * 1);
    // The same place: all is shared, and faces meet in the twelve edges.
    EXPECT_EQ(contour_of(cube, cube, {}).length(), 12 * 2);
    // Sheets side by side.
    const TriangleMesh sheet = mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)},
                                       {{0, 1, 2}, {0, 2, 3}});
    EXPECT_EQ(contour_of(sheet, sheet, shifted(Vec3(1, 0, 0))).length(), 1);
    EXPECT_EQ(contour_of(sheet, sheet, shifted(Vec3(0.5, 0, 0))).length(), 3);
}

TEST(IntersectionContour, HasNoPointsWithinSharedAreas)
{
    // The diagonal of a square crosses edges of a grid, and vertices of it are within the triangles.
    const TriangleMesh square = mesh_of(
        {Vec3(-4, -4, 0), Vec3(4, -4, 0), Vec3(4, 4, 0), Vec3(-4, 4, 0)}, {{0, 1, 2}, {0, 2, 3}});
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    constexpr std::uint32_t columns = 8;
    constexpr std::uint32_t rows = 3;
    for (std::uint32_t i = 0; i <= columns; ++i) {
        for (std::uint32_t k = 0; k <= rows; ++k) {
            positions.emplace_back(0.5 * i - 2, k - 1.25, 0);
            if (i == 0 || k == 0) continue;
            const std::uint32_t at = i * (rows + 1) + k;
            triangles.push_back({at - rows - 2, at - 1, at});
            triangles.push_back({at - rows - 2, at, at - rows - 1});
        }
    }
    const TriangleMesh grid = mesh_of(positions, triangles);
    for (const IntersectionContour& contour :
         {contour_of(square, grid, {}), contour_of(grid, square, {})}) {
        ASSERT_EQ(contour.lines.size(), 1U);
        EXPECT_TRUE(contour.lines[0].closed);
        EXPECT_EQ(contour.length(), 2 * (4 + 3));
    }
    // All sides of a square that covers itself, the diagonals crossed, come in pairs: its corners say
    // that the two meet.
    const TriangleMesh doubled =
        mesh_of({Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0)},
                {{0, 1, 2}, {0, 2, 3}, {1, 0, 3}, {1, 3, 2}});
    const TriangleMesh large =
        mesh_of({Vec3(-9, -9, 0), Vec3(9, -9, 0), Vec3(0, 9, 0)}, {{0, 1, 2}});
    EXPECT_FALSE(contour_of(large, doubled, {}).lines.empty());
}

TEST(IntersectionContour, IsThatOfTheMovedMeshWhereThePoseMovesVerticesTogether)
{
    const TriangleMesh ball = moved(make_icosphere(3), [](const Vec3& p) { return Vec3(5 * p); });
    for (const int exponent : {51, 52, 53}) {
        SCOPED_TRACE(exponent);
        const RigidTransform pose = shifted(Vec3::Constant(std::ldexp(1.25, exponent)));
        const TriangleMesh cube =
            moved(make_cube(), [&](const Vec3& p) { return pose(Vec3(4 * p + Vec3(2, 4, 6))); });
        const TriangleMesh there = moved(ball, [&](const Vec3& p) { return pose(p); });
        const IntersectionContour contour = contour_of(cube, ball, pose);
        EXPECT_FALSE(contour.points.empty());
        expect_same(contour, contour_of(cube, there, {}));
    }
}

TEST(IntersectionContour, OfATouchIsAPointOrAnEdge)
{
    const TriangleMesh cube = make_cube();
    const IntersectionContour corner = contour_of(cube, cube, shifted(Vec3(2, 2, 2)));
    ASSERT_EQ(corner.lines.size(), 1U);
    ASSERT_EQ(corner.points.size(), 1U);
    EXPECT_EQ(corner.points[0].position, Vec3(1, 1, 1));
    EXPECT_EQ(corner.points[0].on_a.kind, FeatureKind::vertex);
    const IntersectionContour edge = contour_of(cube, cube, shifted(Vec3(2, 2, 1)));
    ASSERT_EQ(edge.lines.size(), 1U);
    EXPECT_FALSE(edge.lines[0].closed);
    EXPECT_EQ(edge.length(), 1);
    EXPECT_TRUE(contour_of(cube, cube, shifted(Vec3(3, 0, 0))).lines.empty());
}

TEST(IntersectionContour, EndsAtTheBordersOfOpenMeshes)
{
    // A sheet that ends inside of the cube.
    const TriangleMesh sheet =
        mesh_of({Vec3(0.3, -3, -2), Vec3(0.2, 3, -2), Vec3(0.1, 0, 0.25)}, {{0, 1, 2}});
    const IntersectionContour contour = contour_of(make_cube(), sheet, {});
    ASSERT_EQ(contour.lines.size(), 1U);
    EXPECT_FALSE(contour.lines[0].closed);
    const auto along = contour.points_of(contour.lines[0]);
    EXPECT_EQ(along.front().on_b.kind, FeatureKind::edge);
    EXPECT_EQ(along.back().on_b.kind, FeatureKind::edge);
}

/// Every triangle with vertices of its own, every second edge's triangle split by one without an
/// area: the same curves.
TEST(IntersectionContour, IsUnchangedBySeamsAndSlivers)
{
    const TriangleMesh whole = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1, 10, 12);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (const TriangleCorners& corners : whole.triangles()) {
        const auto next = static_cast<std::uint32_t>(positions.size());
        for (const std::uint32_t corner : corners) {
            // On a grid that has the midpoints of all edges.
            const Vec3 p = whole.positions()[corner];
            positions.push_back((p * 0x1p20).array().round() * 0x1p-20);
        }
        triangles.push_back({next, next + 1, next + 2});
    }
    const TriangleMesh seamed = mesh_of(positions, triangles);
    for (std::size_t i = 0, count = triangles.size(); i < count; i += 2) {
        // (a, b, c) becomes (a, m, c), (m, b, c) and the segment (a, b, m), m halving the side ab.
        const auto [a, b, c] = triangles[i];
        const auto m = static_cast<std::uint32_t>(positions.size());
        positions.emplace_back((positions[a] + positions[b]) / 2);
        triangles[i] = {a, m, c};
        triangles.push_back({m, b, c});
        triangles.push_back({b, m, a});
    }
    const TriangleMesh slivered = mesh_of(positions, triangles);
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 20, 13);
    std::size_t bridges = 0;
    for (int i = 0; i < 20; ++i) {
        SCOPED_TRACE(i);
        const RigidTransform pose = {
            Eigen::AngleAxisd(0.2 * i, Vec3(1, 2, 3).normalized()).matrix(),
            Vec3(0.05 * i, 0.4, 0)};
        const IntersectionContour one = contour_of(torus, seamed, pose);
        EXPECT_EQ(closed_lines(one), one.lines.size());
        // Turned by the pose, the midpoints leave their edges: that side must stand still.
        const IntersectionContour two = contour_of(slivered, torus, pose.inverse());
        const IntersectionContour three = contour_of(seamed, torus, pose.inverse());
        EXPECT_EQ(closed_lines(two), two.lines.size());
        EXPECT_EQ(two.lines.size(), three.lines.size());
        EXPECT_NEAR(two.length(), three.length(), 1e-12);
        EXPECT_NEAR(one.length(), three.length(), 1e-9);
        bridges += two.points.size() - three.points.size();
    }
    EXPECT_GT(bridges, 100U);
}

/// Every triangle again, turned over or with vertices of its own: the same bits.
TEST(IntersectionContour, OfDoubledFacesIsThatOfOne)
{
    const auto doubled = [](const TriangleMesh& mesh, int times) {
        std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
        std::vector<TriangleCorners> triangles(mesh.triangles().begin(), mesh.triangles().end());
        for (int k = 1; k < times; ++k) {
            for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
                auto [a, b, c] = mesh.triangles()[i];
                if (i % 3 == 0) std::swap(b, c);
                if (i % 3 == 1) {
                    for (std::uint32_t* const corner : {&a, &b, &c}) {
                        positions.push_back(mesh.positions()[*corner]);
                        *corner = static_cast<std::uint32_t>(positions.size() - 1);
                    }
                }
                triangles.push_back({b, c, a});
            }
        }
        return mesh_of(positions, triangles);
    };
    const TriangleMesh cube = make_cube();
    const TriangleMesh sphere = sphere_mesh(Vec3(0.1, 0.2, 0.3), 1.2, 12, 15);
    for (const auto& [a, b] : {std::pair(cube, sphere), std::pair(cube, cube)}) {
        for (const Vec3& by :
             {Vec3(0, 0, 0), Vec3(1, 0.5, 2), Vec3(1, 0, 0), Vec3(0.3, 0.4, 0.5)}) {
            const IntersectionContour one = contour_of(a, b, shifted(by));
            expect_same(contour_of(doubled(a, 2), b, shifted(by)), one);
            expect_same(contour_of(a, doubled(b, 3), shifted(by)), one);
            expect_same(contour_of(doubled(a, 3), doubled(b, 2), shifted(by)), one);
        }
    }
}

TEST(JoinSegments, JoinsSegmentsToLines)
{
    const auto lines = [](std::size_t points, std::vector<SegmentEnds> segments) {
        std::vector<std::pair<std::vector<std::uint32_t>, bool>> list;
        for (const JoinedLine& line : join_segments(points, std::move(segments)))
            list.emplace_back(line.points, line.closed);
        return list;
    };
    using Lines = std::vector<std::pair<std::vector<std::uint32_t>, bool>>;
    EXPECT_EQ(lines(2, {}), (Lines{{{0}, false}, {{1}, false}}));
    EXPECT_EQ(lines(3, {{2, 1}, {0, 1}, {1, 2}}), (Lines{{{0, 1, 2}, false}}));
    EXPECT_EQ(lines(3, {{2, 1}, {0, 1}, {0, 2}}), (Lines{{{0, 1, 2}, true}}));
    // An eight, a T, and a ring with a tail.
    EXPECT_EQ(lines(5, {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 2}}),
              (Lines{{{0, 1, 2}, true}, {{2, 3, 4}, true}}));
    EXPECT_EQ(lines(4, {{0, 1}, {1, 2}, {1, 3}}), (Lines{{{0, 1, 2}, false}, {{1, 3}, false}}));
    EXPECT_EQ(lines(4, {{0, 1}, {1, 2}, {2, 0}, {0, 3}}),
              (Lines{{{0, 1, 2}, true}, {{0, 3}, false}}));
}

} // namespace
} // namespace proxima::intersection_contour_test
