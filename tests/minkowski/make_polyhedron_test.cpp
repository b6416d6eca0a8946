#include "proxima/convex_polyhedron.h"

#include "code_of.h"
#include "minkowski/drawn_surface.h"
#include "polytopes.h"
#include "proxima/minkowski_sum.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <string_view>
#include <tuple>

namespace proxima::make_polyhedron_test {
namespace {

using test::Points;

std::string message_of(const Result<ConvexPolyhedron>& result)
{
    return result ? "accepted" : describe(result.error());
}

TriangleMesh mesh_of(Points points, std::vector<TriangleCorners> triangles)
{
    return make_triangle_mesh(std::move(points), std::move(triangles)).value();
}

/// The triangulated surface of a body, every corner moved by `shift`.
TriangleMesh surface_at(const ConvexPolyhedron& body, const Vec3& shift)
{
    Points points(body.points().begin(), body.points().end());
    for (Vec3& p : points) p += shift;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t f = 0; f < body.facet_count(); ++f) {
        const auto loop = body.facet_loop(f);
        for (std::size_t i = 2; i < loop.size(); ++i)
            triangles.push_back({loop[0], loop[i - 1], loop[i]});
    }
    return mesh_of(std::move(points), std::move(triangles));
}

/// Bodies whose coordinates are multiples of 1/8: exact, too, under the shifts below.
std::vector<ConvexPolyhedron> exact_bodies()
{
    std::mt19937 random(28);
    std::vector<ConvexPolyhedron> bodies = {
        test::hull_of({{0, 0, 0}, {-1, 4, 3}, {0, 3, 0}, {-1, -3, -2}}),
        test::hull_of(test::cube_points(1))};
    while (bodies.size() < 100) {
        Points points =
            bodies.size() % 2 == 0 ? test::whole_points(random, 4, 4) : test::nasty_points(random);
        for (Vec3& p : points) p /= 8;
        const ConvexPolyhedron body = test::hull_of(points);
        if (body.dimension() == 3) bodies.push_back(body);
    }
    return bodies;
}

const std::array<Vec3, 6> exact_shifts = {
    Vec3(0, 0, 0),           Vec3(5e5, 5.4e6, 100),      Vec3::Constant(0x1p+20),
    Vec3::Constant(0x1p+24), Vec3(0x1p+28, -0x1p+26, 0), Vec3::Constant(0x1p+30)};

TEST(PolyhedronOfMesh, AcceptsConvexSamples)
{
    for (const char* name : {"cube", "octahedron", "icosphere:3", "sphere:50x50"}) {
        const auto mesh = sample_mesh(name);
        const auto polyhedron = polyhedron_of_mesh(*mesh);
        ASSERT_TRUE(polyhedron) << name << ": " << message_of(polyhedron);
        EXPECT_EQ(polyhedron->points().size(), mesh->vertex_count());
    }
    EXPECT_EQ(polyhedron_of_mesh(make_cube())->facet_count(), 6U);
}

/// A triangle's own corners are never beyond its plane, whatever heights are rounded to.
TEST(PolyhedronOfMesh, AcceptsExactBodiesAnywhereWithoutTolerance)
{
    for (const ConvexPolyhedron& body : exact_bodies()) {
        for (const Vec3& shift : exact_shifts) {
            SCOPED_TRACE(shift.transpose());
            const TriangleMesh mesh = surface_at(body, shift);
            for (const double tolerance : {1e-9, 0.0}) {
                const auto found = polyhedron_of_mesh(mesh, {tolerance});
                ASSERT_TRUE(found) << message_of(found);
                ASSERT_EQ(found->points().size(), body.points().size());
                ASSERT_EQ(found->facet_count(), body.facet_count());
            }
        }
    }
}

TEST(PolyhedronOfMesh, RefusesTheLeastDentAnywhereWithoutTolerance)
{
    // A point within a triangle, pushed in by few of the least steps of its coordinate.
    const TriangleMesh cube = make_cube();
    const TriangleCorners& side = cube.triangles()[0];
    for (const Vec3& shift : exact_shifts) {
        SCOPED_TRACE(shift.transpose());
        const auto dented = [&](double depth) {
            Points points(cube.positions().begin(), cube.positions().end());
            points.emplace_back((points[side[0]] + points[side[1]] + 2 * points[side[2]]) / 4);
            for (Vec3& p : points) p += shift;
            const Vec3 corner = points[side[0]];
            for (int axis = 0; axis < 3; ++axis) {
                if (points[side[1]][axis] != corner[axis] || points[side[2]][axis] != corner[axis])
                    continue;
                const double inward = corner[axis] > shift[axis] ? -depth : depth;
                points.back()[axis] += inward;
            }
            std::vector<TriangleCorners> sides(cube.triangles().begin() + 1,
                                               cube.triangles().end());
            for (std::size_t i = 0; i < 3; ++i) sides.push_back({side[i], side[(i + 1) % 3], 8});
            return polyhedron_of_mesh(mesh_of(points, sides), {0});
        };
        const double least = 0x1p-52 * std::max(1.0, 2 * shift.cwiseAbs().maxCoeff());
        EXPECT_TRUE(dented(0)) << message_of(dented(0));
        EXPECT_NE(message_of(dented(least)).find("not convex"), std::string::npos);
    }
}

/// The sum with a cube is the one at the origin, moved.
TEST(PolyhedronOfMesh, SumsAreThoseAtTheOriginMoved)
{
    const auto cube = test::hull_of(test::cube_points(1));
    const auto corners_of = [](const MinkowskiSum& sum, const Vec3& shift) {
        std::vector<std::tuple<double, double, double>> corners;
        for (std::uint32_t v = 0; v < sum.point_count(); ++v) {
            const Vec3 p = sum.position(v) - shift;
            corners.emplace_back(p.x(), p.y(), p.z());
        }
        std::ranges::sort(corners);
        return corners;
    };
    for (const ConvexPolyhedron& body : exact_bodies()) {
        const auto here = minkowski_sum(body, cube);
        ASSERT_TRUE(here);
        for (const Vec3& shift : exact_shifts) {
            SCOPED_TRACE(shift.transpose());
            const auto moved = polyhedron_of_mesh(surface_at(body, shift));
            ASSERT_TRUE(moved) << message_of(moved);
            const auto there = minkowski_sum(*moved, cube);
            ASSERT_TRUE(there);
            ASSERT_EQ(there->facet_count(), here->facet_count());
            ASSERT_EQ(corners_of(*there, shift), corners_of(*here, Vec3::Zero()));
        }
    }
}

TEST(PolyhedronOfMesh, RefusesOtherMeshesAndSaysWhere)
{
    const auto torus = make_torus(12, 8);
    EXPECT_NE(message_of(polyhedron_of_mesh(torus)).find("not convex"), std::string::npos);

    // A cube with one corner pushed in.
    const TriangleMesh cube = make_cube();
    Points dented(cube.positions().begin(), cube.positions().end());
    dented[0] *= 0.3;
    const std::vector<TriangleCorners> sides(cube.triangles().begin(), cube.triangles().end());
    EXPECT_NE(message_of(polyhedron_of_mesh(mesh_of(dented, sides))).find("beyond the plane of"),
              std::string::npos);

    std::vector<TriangleCorners> open = sides;
    open.pop_back();
    const Points corners(cube.positions().begin(), cube.positions().end());
    EXPECT_NE(message_of(polyhedron_of_mesh(mesh_of(corners, open))).find("the mesh is open"),
              std::string::npos);
    std::vector<TriangleCorners> twice = sides;
    twice.push_back(sides[0]);
    EXPECT_NE(message_of(polyhedron_of_mesh(mesh_of(corners, twice))).find("branches"),
              std::string::npos);

    Points two = corners;
    std::vector<TriangleCorners> both = sides;
    for (const Vec3& p : corners) two.emplace_back(p + Vec3(5, 0, 0));
    for (const auto& t : sides) both.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    EXPECT_NE(message_of(polyhedron_of_mesh(mesh_of(two, both))).find("several components"),
              std::string::npos);

    Points flat = corners;
    for (Vec3& p : flat) p.z() = 0;
    EXPECT_NE(message_of(polyhedron_of_mesh(mesh_of(flat, sides))).find("no volume"),
              std::string::npos);
    Points bad = corners;
    bad[3].x() = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(polyhedron_of_mesh(mesh_of(bad, sides)));
    EXPECT_FALSE(polyhedron_of_mesh(TriangleMesh()));
}

TEST(PolyhedronOfMesh, RefusesTinyConcaveAndFoldedMeshes)
{
    const TriangleMesh cube = make_cube();
    const std::vector<TriangleCorners> sides(cube.triangles().begin(), cube.triangles().end());
    Points tiny(cube.positions().begin(), cube.positions().end());
    tiny[0] *= 0.3;
    for (Vec3& p : tiny) p *= 1e-165;
    EXPECT_NE(message_of(polyhedron_of_mesh(mesh_of(tiny, sides))).find("not convex"),
              std::string::npos);
    // The cube without its top, walls doubled: closed, and all on the hull, but open.
    Points both(cube.positions().begin(), cube.positions().end());
    std::vector<TriangleCorners> folded;
    const auto at_top = [&](std::uint32_t v) { return cube.positions()[v].z() > 0; };
    for (const Vec3& p : cube.positions()) both.push_back(p);
    for (const TriangleCorners& t : sides) {
        if (at_top(t[0]) && at_top(t[1]) && at_top(t[2])) continue;
        // The inner copy shares the rim.
        const auto inner = [&](std::uint32_t v) { return at_top(v) ? v : v + 8; };
        folded.push_back(t);
        folded.push_back({inner(t[0]), inner(t[2]), inner(t[1])});
    }
    const auto result = polyhedron_of_mesh(mesh_of(both, folded));
    EXPECT_NE(message_of(result).find("folded"), std::string::npos) << message_of(result);
}

/// Three walls of a cube, each doubled. Two edges have a vertex halfway, so that every edge has two
/// triangles.
TEST(PolyhedronOfMesh, RefusesDoubledWallsOfTheHullsArea)
{
    const Points points = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0},   {0, 0, 1},
                           {0, 1, 1}, {1, 0, 1}, {1, 1, 1}, {0, 0.5, 0}, {1, 0.5, 0}};
    std::vector<TriangleCorners> folded = {
        {4, 0, 8}, {4, 8, 1}, {4, 1, 5}, {8, 0, 2}, {8, 2, 9}, {8, 9, 3}, {8, 3, 1}, {6, 2, 9},
        {6, 9, 3}, {6, 3, 7}, {0, 1, 5}, {0, 5, 4}, {0, 1, 3}, {0, 3, 2}, {2, 3, 7}, {2, 7, 6}};
    for (int turned = 0; turned < 2; ++turned) {
        for (const double size : {1.0, 1e-165, 1e80}) {
            Points scaled = points;
            for (Vec3& p : scaled) p *= size;
            const auto result = polyhedron_of_mesh(mesh_of(scaled, folded));
            EXPECT_NE(message_of(result).find("folded"), std::string::npos) << message_of(result);
        }
        for (std::size_t t = 0; t < folded.size(); t += 3) std::swap(folded[t][0], folded[t][1]);
    }
}

TEST(PolyhedronOfMesh, RefusesASurfaceWithOneSide)
{
    // The projective plane of six vertices.
    const Points points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {2, 3, 5}};
    const std::vector<TriangleCorners> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5},
                                                    {0, 5, 1}, {1, 2, 4}, {2, 3, 5}, {3, 4, 1},
                                                    {4, 5, 2}, {5, 1, 3}};
    const auto result = polyhedron_of_mesh(mesh_of(points, triangles));
    EXPECT_NE(message_of(result).find("one side only"), std::string::npos) << message_of(result);
}

/// Flatter than roundings and than the tolerance: no volume tells whether the hull is wrapped.
TEST(PolyhedronOfMesh, AcceptsDiscsThatAreHardlyThick)
{
    const Vec3 right = Vec3(1, 2, 3).normalized();
    const Vec3 up = right.cross(Vec3(0, 1, 0)).normalized();
    for (const double thickness : {0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3}) {
        SCOPED_TRACE(thickness);
        Points points;
        std::vector<TriangleCorners> triangles;
        const std::uint32_t sides = 60;
        for (std::uint32_t i = 0; i < sides; ++i) {
            const double angle = 2 * 3.14159265358979 * i / sides;
            points.push_back(std::cos(angle) * right + std::sin(angle) * up);
            triangles.push_back({i, (i + 1) % sides, sides});
            triangles.push_back({(i + 1) % sides, i, sides + 1});
        }
        points.push_back(-0.5 * thickness * right.cross(up));
        points.push_back(0.5 * thickness * right.cross(up));
        const auto result = polyhedron_of_mesh(mesh_of(points, triangles));
        EXPECT_TRUE(result) << message_of(result);
    }
}

/// An apex with all sides around it is not gone around for every one of them.
TEST(PolyhedronOfMesh, TakesConesOfManySidesInTheTimeOfTheirHull)
{
    const std::uint32_t sides = 50000;
    Points points;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < sides; ++i) {
        const double angle = 2 * 3.14159265358979 * i / sides;
        points.emplace_back(std::cos(angle), std::sin(angle), 0);
        triangles.push_back({i, (i + 1) % sides, sides});
        triangles.push_back({(i + 1) % sides, i, sides + 1});
    }
    points.emplace_back(0, 0, 1);
    points.emplace_back(0, 0, -1);
    const TriangleMesh mesh = mesh_of(points, triangles);
    const double of_hull =
        test::processor_time([&] { EXPECT_EQ(convex_hull(points)->facet_count(), 2 * sides); });
    const double of_mesh = test::processor_time(
        [&] { EXPECT_EQ(polyhedron_of_mesh(mesh)->facet_count(), 2 * sides); });
    EXPECT_LT(of_mesh, 3 * of_hull);
}

TEST(PolyhedronOfMesh, IsCancelledWhileItHoldsTrianglesAgainstTheirHull)
{
    const TriangleMesh ball = make_icosphere(3);
    std::set<double> fractions;
    bool is_done = false;
    for (std::uint64_t reports = 1; !is_done; ++reports) {
        Progress progress;
        progress.cancel_after(reports);
        const auto made = polyhedron_of_mesh(ball, {.execution = {.progress = &progress}});
        is_done = made.has_value();
        if (is_done) continue;
        EXPECT_EQ(code_of(made), ErrorCode::cancelled);
        if (progress.stage() == std::string_view("holding triangles against their hull"))
            fractions.insert(progress.fraction());
    }
    EXPECT_GE(fractions.size(), 10U) << "of 20 blocks of triangles";
}

TEST(PolyhedronOfMesh, IgnoresOrientationAndUnusedVertices)
{
    const TriangleMesh cube = make_cube();
    Points points(cube.positions().begin(), cube.positions().end());
    points.emplace_back(100, 0, 0); // of no triangle
    std::vector<TriangleCorners> sides(cube.triangles().begin(), cube.triangles().end());
    std::swap(sides[4][0], sides[4][1]);
    const auto polyhedron = polyhedron_of_mesh(mesh_of(points, sides));
    ASSERT_TRUE(polyhedron) << message_of(polyhedron);
    EXPECT_EQ(polyhedron->facet_count(), 6U);
    EXPECT_EQ(polyhedron->points().size(), 8U);
}

TEST(PolyhedronOfMesh, NamesAVertexThatIsTooFarAwayByItsNumberInTheMesh)
{
    const TriangleMesh mesh = mesh_of({{5, 5, 5}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e91}},
                                      {{1, 3, 2}, {1, 2, 4}, {1, 4, 3}, {2, 3, 4}});
    const auto polyhedron = polyhedron_of_mesh(mesh);
    ASSERT_FALSE(polyhedron);
    EXPECT_EQ(code_of(polyhedron), ErrorCode::limit_exceeded);
    EXPECT_NE(message_of(polyhedron).find("vertex 4"), std::string::npos) << message_of(polyhedron);
}

TEST(PolyhedronOfBox, RefusesEmptyBoxes)
{
    const Vec3 ones = Vec3::Ones();
    for (const Vec3& below : {ones, Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
        const auto box = polyhedron_of_box({below, ones - below});
        ASSERT_FALSE(box) << below.transpose();
        EXPECT_EQ(code_of(box), ErrorCode::invalid_argument) << below.transpose();
    }
    EXPECT_EQ(polyhedron_of_box({Vec3::Zero(), ones})->facet_count(), 6U);
}

/// Every corner is in all half-spaces, and every half-space that matters is reached.
TEST(PolyhedronOfHalfSpaces, RecoversAHull)
{
    for (unsigned seed = 0; seed < 300; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        const bool unbounded = seed % 3 == 0;
        Points rays;
        if (unbounded) rays = {{1, 0, 0}, {3, 1, 0}, {3, 0, 1}};
        const auto hull = convex_hull(test::nasty_points(random), rays).value();
        if (hull.dimension() < 3) continue;
        std::vector<HalfSpace> planes;
        for (std::uint32_t f = 0; f < hull.facet_count(); ++f) {
            planes.push_back(hull.half_space(f));
            planes.push_back({2 * planes.back().normal, 2 * planes.back().offset + 5}); // idle
        }
        std::ranges::shuffle(planes, random);
        const auto found = polyhedron_of_half_spaces(planes);
        ASSERT_TRUE(found) << message_of(found);
        ASSERT_EQ(found->points().size(), hull.points().size());
        EXPECT_EQ(found->rays().size(), hull.rays().size());
        double size = 1;
        for (const Vec3& p : hull.points()) size = std::max(size, p.norm());
        for (const Vec3& p : hull.points()) {
            double nearest = size;
            for (const Vec3& q : found->points()) nearest = std::min(nearest, (p - q).norm());
            EXPECT_LT(nearest, 1e-10 * size);
        }
        for (const Vec3& r : hull.rays()) {
            double nearest = 1;
            for (const Vec3& q : found->rays())
                nearest = std::min(nearest, (r.normalized() - q.normalized()).norm());
            EXPECT_LT(nearest, 1e-9);
        }
    }
}

TEST(PolyhedronOfHalfSpaces, RefusesBadInput)
{
    const auto refused = [](std::vector<HalfSpace> planes, const char* why) {
        const auto result = polyhedron_of_half_spaces(planes);
        EXPECT_NE(message_of(result).find(why), std::string::npos) << message_of(result);
    };
    const Vec3 x = Vec3::UnitX();
    const Vec3 y = Vec3::UnitY();
    const Vec3 z = Vec3::UnitZ();
    refused({}, "line");
    refused({{x, 1}}, "line");
    refused({{x, 1}, {-x, 1}, {y, 1}, {-y, 1}}, "line");
    refused({{x, -1}, {-x, -1}, {y, 1}, {-y, 1}, {z, 1}, {-z, 1}}, "no volume");
    refused({{x, 0}, {-x, 0}, {y, 1}, {-y, 1}, {z, 1}, {-z, 1}}, "no volume");
    refused({{Vec3::Zero(), 1}}, "no length");
    refused({{x, std::numeric_limits<double>::quiet_NaN()}}, "NaN");
    // Far from the origin, and a corner only.
    std::vector<HalfSpace> far = {{x, 1001}, {-x, -1000}, {y, 1}, {-y, 1}, {z, 1}, {-z, 1}};
    EXPECT_EQ(polyhedron_of_half_spaces(far)->points().size(), 8U);
    const auto octant = polyhedron_of_half_spaces(std::vector<HalfSpace>{{x, 1}, {y, 2}, {z, 3}});
    ASSERT_TRUE(octant) << message_of(octant);
    EXPECT_EQ(octant->points().size(), 1U);
    EXPECT_EQ(octant->rays().size(), 3U);
}

TEST(DrawnSurface, CutsRaysAtALength)
{
    const auto cube = test::hull_of(test::cube_points(1));
    EXPECT_EQ(triangulate(*draw(cube))->triangle_count(), 12U);
    const auto prism = convex_hull(Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, Points{{0, 0, 1}});
    const auto mesh = triangulate(*draw(*prism, 10));
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->vertex_count(), 6U);
    EXPECT_EQ(mesh->triangle_count(), 7U);
    EXPECT_EQ(bounding_box(*mesh).upper.z(), 10);
    EXPECT_FALSE(draw(test::hull_of({{0, 0, 0}, {1, 0, 0}})));
    EXPECT_EQ(draw(*prism, 1e300)->positions.back().z(), 1e300);
    // A closed surface: the volume of cube (+) octahedron is that of its parts (Steiner's formula
    // by hand: 8 + 4/3 + 6 faces 4 x 1 + 12 edges' prisms 2 x 1/2).
    const auto sum = *minkowski_sum(cube, test::hull_of(test::octahedron_points(1)));
    const auto surface = *triangulate(*draw(sum));
    double volume = 0;
    for (std::uint32_t t = 0; t < surface.triangle_count(); ++t) {
        const Triangle triangle = surface.triangle(TriangleId{t});
        volume += triangle[0].dot(triangle[1].cross(triangle[2])) / 6;
    }
    EXPECT_DOUBLE_EQ(volume, 8 + 4.0 / 3 + 6 * 4 * 1 + 12 * 2 * 0.5);
}

TEST(DrawnSurface, RefusesCornersThatAreNotFinite)
{
    const auto cube = test::hull_of(test::cube_points(10));
    const auto sum = *minkowski_sum(cube, cube);
    EXPECT_TRUE(draw(sum.scaled(1e306)));
    const auto surface = draw(sum.scaled(1e308));
    ASSERT_FALSE(surface);
    EXPECT_EQ(code_of(surface), ErrorCode::limit_exceeded);
}

} // namespace
} // namespace proxima::make_polyhedron_test
