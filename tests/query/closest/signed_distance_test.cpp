#include "proxima/signed_distance.h"

#include "counted_allocations.h"
#include "geometry/triangle_contact.h"
#include "octree/winding_number.h"
#include "oracles/exact_winding.h"
#include "proxima/mesh_io.h"
#include "proxima/neighbourhood.h"
#include "query/closest/brute_force.h"
#include "query/closest/signed_mesh.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <thread>

namespace proxima::signed_distance_test {
namespace {

using namespace testing;

using Methods = std::map<SignMethod, int>;

/// Checks signs against exact crossings, for a closed mesh, and counts the methods.
Methods expect_exact_signs(const Signed& of, int points, unsigned seed)
{
    Methods methods;
    const double box_size = bounding_box(of.mesh).extent().maxCoeff();
    for (const Vec3& p : proximity_points(of.mesh, points, seed)) {
        const SignedDistance found = of.at(p);
        ++methods[found.method];
        const double size = std::max(p.cwiseAbs().maxCoeff(), of.mesh.positions()[0].norm());
        const double unsigned_distance = std::sqrt(found.closest.squared_distance);
        if (found.distance == 0) {
            EXPECT_EQ(found.method, SignMethod::on_surface);
            EXPECT_LE(unsigned_distance, 1e-15 * std::max(size, box_size));
            continue;
        }
        EXPECT_EQ(std::abs(found.distance), unsigned_distance);
        // Within rounding of the surface either side will do.
        if (std::abs(found.distance) < 1e-14 * size) continue;
        const auto winding = oracle::exact_winding(of.mesh, p);
        if (!winding) continue;
        EXPECT_EQ(found.distance < 0, *winding >= 1)
            << "point " << p.transpose() << " distance " << found.distance << " winding "
            << *winding << " by " << name_of(found.method);
    }
    return methods;
}

/// The tetrahedron 0 1 2 3 with the face opposite vertex 3 cut into many triangles at vertex 0.
TriangleMesh cut_tetrahedron(int cuts)
{
    std::vector<Vec3> positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    std::vector<TriangleCorners> triangles = {{0, 1, 3}, {0, 3, 2}};
    std::uint32_t last = 1;
    for (int i = 1; i <= cuts; ++i) {
        const double t = static_cast<double>(i) / cuts;
        std::uint32_t next = 2;
        if (i < cuts) {
            next = static_cast<std::uint32_t>(positions.size());
            positions.emplace_back(1 - t, t, 0);
        }
        triangles.push_back({0, next, last});
        triangles.push_back({3, last, next});
        last = next;
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

TEST(SignedDistance, OfCleanSurfacesIsExactByPseudonormals)
{
    std::vector<NamedMesh> meshes = {
        {"cube", cube_mesh(Vec3(0.3, 0, 0), 1.0)},
        {"ball", ball(Vec3::Zero(), 1.0)},
        {"torus", torus_mesh(1.0, 0.3, 20, 10)},
        {"knife", knife(0.05)},
        {"cut tetrahedron", cut_tetrahedron(40)},
        {"two balls", joined(ball(Vec3::Zero(), 1.0), ball(Vec3(2.5, 0, 0), 1.0))},
        {"a shell", joined(ball(Vec3::Zero(), 1.0), inverted(ball(Vec3::Zero(), 0.5)))},
        {"far away", moved(torus_mesh(1.0, 0.3, 20, 10),
                           [](const Vec3& p) { return Vec3(p + Vec3(1e6, 2e6, -1e6)); })},
        {"tiny", moved(knife(0.3), [](const Vec3& p) { return Vec3(1e-40 * p); })},
        {"huge", moved(knife(0.3), [](const Vec3& p) { return Vec3(1e40 * p); })}};
    // Spikes and pits of all sizes: every edge and vertex may be closest from either side.
    std::mt19937 random(2);
    std::uniform_real_distribution<double> factor(0.3, 1.0);
    for (int i = 0; i < 6; ++i) {
        meshes.push_back({"spiky " + std::to_string(i),
                          moved(ball(Vec3::Zero(), 1.0),
                                [&](const Vec3& p) { return Vec3(factor(random) * p); })});
    }
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const Signed of(named.mesh);
        EXPECT_TRUE(of.is_local());
        Methods methods = expect_exact_signs(of, 1500, 21);
        EXPECT_GE(methods[SignMethod::pseudonormal], 1000);
        EXPECT_EQ(methods[SignMethod::winding_number], 0) << "no random point is in doubt";
    }
}

TEST(SignedDistance, WeightsNormalsByAngles)
{
    // Seen from in front of the two whole faces, many thin triangles must not outvote them.
    const Signed of(cut_tetrahedron(60));
    const Vec3 corner = Vec3::Zero();
    int outside = 0;
    for (const Vec3& toward : {Vec3(-1, -1, -0.01), Vec3(-1, -0.1, -0.1), Vec3(-0.01, -1, -0.01),
                               Vec3(-0.01, -0.01, -1), Vec3(-1, -1, -1)}) {
        const SignedDistance found = of.at(corner + 0.1 * toward);
        EXPECT_EQ(found.closest.feature, (Feature{FeatureKind::vertex, 0}));
        EXPECT_EQ(found.method, SignMethod::pseudonormal);
        outside += found.distance > 0 ? 1 : 0;
    }
    EXPECT_EQ(outside, 5);
    const Vec3 normal(of.arrays().vertices[0].normal.data());
    EXPECT_LT((normal - Vec3(-1, -1, -1).normalized()).norm(), 1e-12);
}

TEST(SignedDistance, LeavesPointsBesideAPseudonormalToTheWindingNumber)
{
    // A spear's head so flat that points beside its tip, all but across the tip's pseudonormal, are
    // closest to the tip.
    constexpr double flat = 1e-6;
    const Signed spear(mesh_of({Vec3(0, 0, 0), Vec3(1, -flat, -1), Vec3(1, flat, -1),
                                Vec3(-1, flat, -1), Vec3(-1, -flat, -1)},
                               {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {1, 4, 3}, {1, 3, 2}}));
    ASSERT_TRUE(spear.is_local());
    for (const double tilt : {1.5e-6, 3e-6, 5e-6, 1e-3, 1.0}) {
        const SignedDistance found = spear.at(0.01 * Vec3(0, 1, tilt));
        ASSERT_EQ(found.closest.feature.kind, FeatureKind::vertex) << tilt;
        EXPECT_GT(found.distance, 0) << tilt;
        constexpr double doubtful = 0x1p-18; // of the distance
        EXPECT_EQ(found.method,
                  tilt < doubtful ? SignMethod::winding_number : SignMethod::pseudonormal)
            << name_of(found.method) << " at " << tilt;
    }
}

TEST(SignedDistance, FollowsTheWindingNumberThroughNestedAndInvertedParts)
{
    const TriangleMesh outer = ball(Vec3::Zero(), 1.0);
    const TriangleMesh inner = ball(Vec3::Zero(), 0.5);
    const TriangleMesh core = ball(Vec3::Zero(), 0.2);
    struct Case {
        const char* name;
        TriangleMesh mesh;
        std::array<bool, 4>
            inside; // at 0, between core and inner, between inner and outer, outside
    };
    const std::vector<Case> cases = {
        {"all outward", joined(joined(outer, inner), core), {true, true, true, false}},
        {"onion", joined(joined(outer, inverted(inner)), core), {true, false, true, false}},
        {"inverted alone",
         joined(joined(inverted(outer), inverted(inner)), inverted(core)),
         {false, false, false, false}},
        {"inverted outside",
         joined(joined(inverted(outer), inner), core),
         {true, false, false, false}},
        {"pit in a pit",
         joined(joined(outer, inverted(inner)), inverted(core)),
         {false, false, true, false}}};
    for (const Case& each : cases) {
        SCOPED_TRACE(each.name);
        const Signed of(each.mesh);
        EXPECT_TRUE(of.is_local());
        const std::array<Vec3, 4> points = {Vec3(0.01, 0.02, 0.03), Vec3(0.3, 0.1, 0),
                                            Vec3(0, 0.5, 0.5), Vec3(1, 1, 1)};
        for (std::size_t i = 0; i < points.size(); ++i) {
            const SignedDistance found = of.at(points[i]);
            EXPECT_EQ(found.distance < 0, each.inside[i]) << "point " << i;
            EXPECT_EQ(found.method, SignMethod::pseudonormal);
        }
        (void)expect_exact_signs(of, 600, 22);
    }
}

TEST(SignedDistance, UsesTheWindingNumberWhereTheSurfaceMeetsItself)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    const TriangleMesh lens = mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                                      {{0, 1, 2}, {0, 2, 1}}); // two sides, nothing between
    const std::vector<NamedMesh> meshes = {
        {"overlapping balls", joined(ball(Vec3::Zero(), 1.0), ball(Vec3(1, 0.1, 0.2), 1.0))},
        {"twice the same", joined(cube, cube)},
        {"a cube and its inverse", joined(cube, inverted(cube))},
        {"touching at a face", joined(cube, cube_mesh(Vec3(2, 0, 0), 1.0))},
        {"touching at part of a face", joined(cube, cube_mesh(Vec3(1.5, 0.25, 0), 0.5))},
        {"touching at an edge", joined(cube, cube_mesh(Vec3(2, 2, 0), 1.0))},
        {"touching at a corner", joined(cube, cube_mesh(Vec3(2, 2, 2), 1.0))},
        {"corner in a face",
         joined(cube, moved(cut_tetrahedron(3),
                            [](const Vec3& p) { return Vec3(p + Vec3(1, 0.25, 0.25)); }))},
        {"parts of a ship", sample_mesh("spaceship:1300").value()},
        {"lens", lens}};
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const Signed of(named.mesh);
        EXPECT_FALSE(of.is_local());
        Methods methods = expect_exact_signs(of, 900, 23);
        EXPECT_GT(methods[SignMethod::winding_number], 50);
    }
    // Only along the seam is anything doubtful.
    const Signed seam(joined(sphere_mesh(Vec3::Zero(), 1.0, 30, 30),
                             sphere_mesh(Vec3(1, 0.1, 0.2), 1.0, 30, 30)));
    Methods of_seam = expect_exact_signs(seam, 900, 32);
    EXPECT_GT(of_seam[SignMethod::pseudonormal], 500);
    std::size_t doubtful = 0;
    std::size_t inside = 0;
    for (const SurfaceSides sides : seam.arrays().sides) {
        doubtful += sides == SurfaceSides::doubtful ? 1 : 0;
        inside += sides == SurfaceSides::inside_both ? 1 : 0;
    }
    EXPECT_LT(doubtful, seam.mesh.triangle_count() / 5);
    // Of the points, no greater part than twice the doubtful part of the triangles.
    EXPECT_LT(of_seam[SignMethod::winding_number],
              static_cast<int>(2 * 900 * doubtful / seam.mesh.triangle_count()));
    EXPECT_GT(doubtful, 40U);
    EXPECT_GT(inside, seam.mesh.triangle_count() / 10);

    // A part that meets nothing keeps its pseudonormals.
    const Signed mixed(
        joined(joined(cube, cube_mesh(Vec3(2, 0, 0), 1.0)), ball(Vec3(9, 0, 0), 1.0)));
    Methods methods = expect_exact_signs(mixed, 900, 24);
    EXPECT_GT(methods[SignMethod::pseudonormal], 100);
    EXPECT_GT(methods[SignMethod::winding_number], 100);
}

TEST(SignedDistance, OfManyPartsThatMeetOrNestIsExact)
{
    // On a coarse grid, so that vertices, edges and faces of many lie on each other or in line.
    constexpr unsigned seed = 25;
    std::mt19937 random(seed);
    const auto below = [&](unsigned n) { return static_cast<double>(random() % n); };
    const TriangleMesh octahedron = sample_mesh("octahedron").value();
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (int part = 0; part < 400; ++part) {
        const Vec3 center(below(30), below(30), below(30));
        const double size = 1 + below(4);
        const bool inward = random() % 5 == 0;
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const Vec3& corner : octahedron.positions())
            positions.emplace_back(center + size * corner);
        for (auto [a, b, c] : octahedron.triangles()) {
            if (inward) std::swap(b, c);
            triangles.push_back({first + a, first + b, first + c});
        }
    }
    const Signed of(mesh_of(std::move(positions), std::move(triangles)));
    Methods methods = expect_exact_signs(of, 900, seed);
    EXPECT_GT(methods[SignMethod::pseudonormal], 100);
    EXPECT_GT(methods[SignMethod::winding_number], 100);
    std::map<SurfaceSides, int> sides;
    for (const SurfaceSides one : of.arrays().sides) ++sides[one];
    EXPECT_EQ(sides.size(), 4U) << "some of each";
    // In the grid's planes and along its lines the ray meets edges and vertices.
    for (int i = 0; i < 1000; ++i) {
        const Vec3 p(below(60) / 2, below(60) / 2, below(60) / 2);
        const SignedDistance found = of.at(p);
        const auto winding = oracle::exact_winding(of.mesh, p);
        if (!winding || found.distance == 0) continue;
        EXPECT_EQ(found.distance < 0, *winding >= 1) << "seed " << seed << ": " << p.transpose();
    }
}

TEST(SignedDistance, IsExactWhereEveryTriangleOfAClosedSurfaceMeetsAnother)
{
    // Two tetrahedra that are needles a trillionth as thick as they are long, with an edge in common
    // and through each other. Near the edge no sum of solid angles in doubles tells.
    constexpr unsigned seed = 29;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(-1, 1);
    const auto near_origin = [&] {
        return Vec3(1e-16 * Vec3(part(random), part(random), part(random)));
    };
    int told = 0;
    for (int mesh = 0; mesh < 20; ++mesh) {
        const Signed of(mesh_of({Vec3(-1, -1, -1), Vec3(4e-12, 0, -1), near_origin(), near_origin(),
                                 near_origin(), near_origin()},
                                {{0, 1, 2},
                                 {0, 3, 1},
                                 {1, 3, 2},
                                 {2, 3, 0},
                                 {1, 3, 4},
                                 {1, 5, 3},
                                 {3, 5, 4},
                                 {4, 5, 1}}));
        if (!std::ranges::all_of(of.arrays().sides,
                                 [](SurfaceSides s) { return s == SurfaceSides::doubtful; }))
            continue;
        for (int i = 0; i < 50; ++i) {
            const Vec3 p(1e-20 * part(random), 1e-20 * part(random), -0.5 + 0.5 * part(random));
            const auto winding = oracle::exact_winding(of.mesh, p);
            if (!winding || of.at(p).distance == 0) continue;
            EXPECT_EQ(of.at(p).distance < 0, *winding >= 1)
                << "seed " << seed << ", mesh " << mesh << ": " << p.transpose();
            ++told;
        }
    }
    EXPECT_GT(told, 300);
}

TEST(SignedDistance, AcceptsPartsThatShareAVertex)
{
    // Two cubes that are one vertex in the file: both separate, one star of twelve triangles.
    const TriangleMesh two = joined(cube_mesh(Vec3::Zero(), 1.0), cube_mesh(Vec3(2, 2, 2), 1.0));
    std::vector<TriangleCorners> triangles(two.triangles().begin(), two.triangles().end());
    for (TriangleCorners& corners : triangles) {
        for (std::uint32_t& corner : corners) corner = corner == 8 ? 7 : corner;
    }
    const Signed outward(mesh_of({two.positions().begin(), two.positions().end()}, triangles));
    EXPECT_TRUE(outward.is_local());
    Methods methods = expect_exact_signs(outward, 900, 25);
    EXPECT_EQ(methods[SignMethod::winding_number], 0) << "no random point is in doubt";
    for (const Vec3& toward : {Vec3(1, -1, 0), Vec3(1, 0.2, -1), Vec3(-1, 1, 1), Vec3(1, 1, -1)}) {
        const Vec3 p = Vec3(1, 1, 1) + 0.1 * toward;
        EXPECT_EQ(outward.at(p).distance < 0, *oracle::exact_winding(outward.mesh, p) >= 1);
    }

    // With one of them turned inside out, the vertex tells nothing, the rest of the first does.
    for (std::size_t i = 12; i < triangles.size(); ++i) std::swap(triangles[i][1], triangles[i][2]);
    const Signed mixed(mesh_of({two.positions().begin(), two.positions().end()}, triangles));
    EXPECT_EQ(mixed.arrays().vertex_sides[7], SurfaceSides::doubtful);
    EXPECT_EQ(mixed.arrays().vertex_sides[0], SurfaceSides::separates);
    EXPECT_EQ(mixed.arrays().vertex_sides[15], SurfaceSides::outside_both);
    (void)expect_exact_signs(mixed, 900, 26);
}

TEST(SignedDistance, AcceptsTrianglesWithoutArea)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    std::vector<Vec3> positions(cube.positions().begin(), cube.positions().end());
    std::vector<TriangleCorners> triangles(cube.triangles().begin(), cube.triangles().end());
    // A segment and a point that are no part of the surface, a segment on it.
    positions.emplace_back(3, 0, 0);
    positions.emplace_back(0.5, 0.25, 0);
    triangles.push_back({8, 8, 9});
    triangles.push_back({9, 9, 9});
    triangles.push_back({0, 0, 7});
    const Signed hung(mesh_of(positions, triangles));
    (void)expect_exact_signs(hung, 900, 27);
    EXPECT_EQ(hung.at(Vec3(3.1, 0.1, 0)).method, SignMethod::winding_number);
    EXPECT_GT(hung.at(Vec3(3.1, 0.1, 0)).distance, 0);
    EXPECT_LT(hung.at(Vec3(0.5, 0.26, 0)).distance, 0);

    // The diagonal (0, 6) of one side cut by a vertex on one side of it only: a triangle of three
    // collinear corners closes the gap.
    positions.assign(cube.positions().begin(), cube.positions().end());
    triangles.assign(cube.triangles().begin(), cube.triangles().end());
    ASSERT_EQ(triangles[0], (TriangleCorners{0, 4, 6}));
    ASSERT_EQ(triangles[1], (TriangleCorners{0, 6, 2}));
    positions.emplace_back(0.5 * (positions[0] + positions[6]));
    triangles[1] = {0, 8, 2};
    triangles.push_back({8, 6, 2});
    triangles.push_back({0, 6, 8});
    const Signed cut(mesh_of(positions, triangles));
    EXPECT_FALSE(cut.is_local());
    Methods methods = expect_exact_signs(cut, 900, 28);
    EXPECT_GT(methods[SignMethod::winding_number], 100);
}

TEST(SignedDistance, FollowsTheWindingNumberOfOpenAndBrokenSurfaces)
{
    const TriangleMesh sphere = ball(Vec3::Zero(), 1.0);
    std::vector<TriangleCorners> turned(sphere.triangles().begin(), sphere.triangles().end());
    std::swap(turned[40][1], turned[40][2]);
    std::vector<NamedMesh> meshes = {
        {"holes", without(sphere, [](std::size_t i) { return i % 7 == 0; })},
        {"half", without(sphere, [](std::size_t i) { return i % 18 > 8; })},
        {"one turned", mesh_of({sphere.positions().begin(), sphere.positions().end()}, turned)},
        {"fans", fans()}};
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        meshes.push_back({"nasty " + std::to_string(seed), nasty_mesh(seed)});
        meshes.push_back({"grid " + std::to_string(seed), grid_mesh(seed)});
    }
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const Signed of(named.mesh);
        for (const Vec3& p : proximity_points(of.mesh, 100, 29)) {
            const SignedDistance found = of.at(p);
            if (found.distance == 0) continue;
            EXPECT_EQ(found.method, SignMethod::winding_number);
            const double winding = brute_winding_number(of.mesh, p);
            if (std::abs(winding - 0.5) < 1e-9) continue;
            EXPECT_EQ(found.distance<0, winding> 0.5) << "winding " << winding;
        }
    }
}

TEST(SignedDistance, OfTheOpenBunnyFollowsTheWindingNumber)
{
    const std::filesystem::path file = PROXIMA_SOURCE_DIR "/../shared/meshes/bun_zipper_res2.ply";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const Signed of(read_mesh(file).value());
    EXPECT_FALSE(of.is_local());
    for (const Vec3& p : proximity_points(of.mesh, 150, 30)) {
        const SignedDistance found = of.at(p);
        if (found.distance == 0) continue;
        EXPECT_EQ(found.method, SignMethod::winding_number);
        EXPECT_EQ(found.distance < 0, brute_is_inside(of.mesh, p));
    }
}

TEST(SignedDistance, OfAScanThatFoldsOntoItselfIsExact)
{
    // Its edges are balanced but not all of two triangles; thin parts pass through each other.
    const std::filesystem::path file = PROXIMA_SOURCE_DIR "/../shared/meshes/dragon_vrip_res3.ply";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const Signed of(read_mesh(file).value());
    Methods methods = expect_exact_signs(of, 150, 33);
    EXPECT_GT(methods[SignMethod::pseudonormal], 100);
    // Next to the doubtful triangles as well.
    std::mt19937 random(34);
    std::uniform_real_distribution<double> part(-1, 1);
    int asked = 0;
    for (std::uint32_t i = 0; i < of.mesh.triangle_count() && asked < 60; i += 7) {
        if (of.sides(TriangleId{i}) == SurfaceSides::separates) continue;
        ++asked;
        const Vec3 p = of.mesh.triangle(TriangleId{i})[0] +
                       2e-4 * Vec3{part(random), part(random), part(random)};
        const SignedDistance found = of.at(p);
        const auto winding = oracle::exact_winding(of.mesh, p);
        if (found.distance == 0 || !winding) continue;
        EXPECT_EQ(found.distance < 0, *winding >= 1) << p.transpose();
    }
    EXPECT_GT(asked, 30);
}

TEST(SignedDistance, IsZeroOnTheSurfaceAndInfiniteWhereSquaresOverflow)
{
    const Signed of(cube_mesh(Vec3::Zero(), 1.0));
    for (const Vec3& p : {Vec3(1, 1, 1), Vec3(1, 0.25, 0.5), Vec3(1, 1, 0.3), Vec3(-1, 0.5, 0.5)}) {
        const SignedDistance found = of.at(p);
        EXPECT_EQ(found.distance, 0.0);
        EXPECT_FALSE(std::signbit(found.distance));
        EXPECT_EQ(found.method, SignMethod::on_surface);
    }
    EXPECT_EQ(of.at(Vec3(1.7e308, 0, 0)).distance, std::numeric_limits<double>::infinity());
    EXPECT_NEAR(of.at(Vec3(0.25, 0.5, 0)).distance, -0.5, 1e-15);
}

TEST(SignedDistance, IsNotZeroBesideVertices)
{
    const Signed of(cube_mesh(Vec3::Zero(), 1.0));
    for (const Vec3& vertex : of.mesh.positions()) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 p = vertex;
            p[axis] *= 1 + std::numeric_limits<double>::epsilon();
            EXPECT_GT(of.at(p).distance, 0) << p.transpose();
        }
    }
}

TEST(SignedDistance, IsZeroOnEdgesWhoseClosestPointIsRounded)
{
    const Signed of(
        mesh_of({Vec3(-116910409, -34924767, -127110825), Vec3(646819913, -553990599, 513393795),
                 Vec3(362551016, 519498126, -746020614), Vec3(-290204827, 171282399, -138348042)},
                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}));
    const Vec3 p(137666365, -207946711, 86390715);
    EXPECT_GT(closest_feature(of.index, p)->squared_distance, 0);
    EXPECT_EQ(of.at(p).distance, 0);
    EXPECT_EQ(of.at(p).method, SignMethod::on_surface);
}

TEST(SignedDistance, DoesNotJoinSurfacesAcrossAnEdgeOfFour)
{
    // Two boxes with one edge in common, the second turned inside out.
    const auto box = [](const Vec3& lower, const Vec3& upper) {
        const TriangleMesh unit = cube_mesh(Vec3::Zero(), 1.0);
        std::vector<Vec3> positions;
        for (const Vec3& p : unit.positions()) {
            positions.emplace_back(0.5 * (lower + upper) + 0.5 * (upper - lower).cwiseProduct(p));
        }
        const auto triangles = unit.triangles();
        return mesh_of(positions, {triangles.begin(), triangles.end()});
    };
    const TriangleMesh two =
        joined(box(Vec3(-1, -1, -1), Vec3(1, 1, 1)), box(Vec3(1, 1, -1), Vec3(1.5, 1.5, 1)));
    std::vector<TriangleCorners> triangles(two.triangles().begin(), two.triangles().end());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for (std::uint32_t& corner : triangles[i]) {
            for (std::uint32_t first = 0; first < 8; ++first)
                if (two.positions()[first] == two.positions()[corner]) corner = first;
        }
        if (i >= 12) std::swap(triangles[i][1], triangles[i][2]);
    }
    const Signed of(mesh_of({two.positions().begin(), two.positions().end()}, triangles));
    EXPECT_NEAR(of.at(Vec3(1.25, 0.9, 0)).distance, 0.1, 1e-12);
    EXPECT_NEAR(of.at(Vec3(0.9, 1.25, 0)).distance, 0.1, 1e-12);
}

TEST(SignedDistance, HasTheSameAnswersOnAnyThreadAndDoesNotAllocate)
{
    const TriangleMesh mesh =
        joined(sample_mesh("spaceship:1300").value(), ball(Vec3(9, 9, 9), 1.0));
    const Signed of(mesh);
    const std::vector<Vec3> points = proximity_points(mesh, 300, 31);
    std::vector<double> truth;
    truth.reserve(points.size());
    const std::size_t before = allocation_count();
    for (const Vec3& p : points) truth.push_back(of.at(p).distance);
    EXPECT_EQ(allocation_count(), before);
    std::vector<std::thread> threads;
    std::atomic<int> wrong = 0;
    for (int k = 0; k < 3; ++k) {
        threads.emplace_back([&] {
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (of.at(points[i]).distance != truth[i]) ++wrong;
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, 0);
}

TEST(SignedDistance, IsTheSignOfTheClosestFeatureThatIsThere)
{
    const Signed of(ball(Vec3::Zero(), 1.0));
    for (const Vec3& p : proximity_points(of.mesh, 100, 35)) {
        const auto closest = closest_feature(of.index, p);
        const SignedDistance found = sign_of(of.index, *closest, p).value();
        EXPECT_EQ(found.distance, of.at(p).distance);
        EXPECT_EQ(found.method, of.at(p).method);
    }
    EXPECT_FALSE(sign_of(of.index, no_closest_feature(), Vec3::Zero()));
}

TEST(SignedDistance, IsNothingWithoutSigns)
{
    const MeshIndex index = build_mesh_index(cube_mesh(Vec3::Zero(), 1.0)).value();
    EXPECT_FALSE(has_local_signs(index));
    EXPECT_FALSE(signed_distance(index, Vec3::Zero()));
    EXPECT_FALSE(sign_of(index, *closest_feature(index, Vec3::Zero()), Vec3::Zero()));
    EXPECT_FALSE(signed_distance(MeshIndex(), Vec3::Zero()));
}

} // namespace
} // namespace proxima::signed_distance_test
