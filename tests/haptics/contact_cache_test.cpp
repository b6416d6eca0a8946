#include "haptics/proxy/contact_cache.h"

#include "base/simd.h"
#include "counted_allocations.h"
#include "geometry/closest_point.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

namespace proxima::contact_cache_test {
namespace {

using testing::HandPath;
using testing::TouchMesh;

std::vector<TouchMesh> cache_meshes()
{
    std::vector<TouchMesh> meshes = testing::touch_meshes();
    // Needles and slivers beside triangles of all sizes, and all of it far from the origin.
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(-1, 1);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 400; ++i) {
        const Vec3 at{place(random), place(random), place(random)};
        const double size = std::pow(10.0, 2.5 * place(random) - 2.5);
        const double width = std::pow(10.0, 3 * place(random) - 3);
        const Vec3 along{place(random), place(random), place(random)};
        const Vec3 aside{place(random), place(random), place(random)};
        positions.emplace_back(at);
        positions.emplace_back(at + size * along);
        positions.emplace_back(at + size * (0.3 * along + width * aside));
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const TriangleMesh slivers = testing::mesh_of(std::move(positions), std::move(triangles));
    meshes.push_back({"slivers", slivers});
    meshes.push_back({"far slivers", testing::moved(slivers, [](const Vec3& p) {
                          return Vec3(p.array() + 3e5);
                      })});
    return meshes;
}

/// The first part of a way, 0 to 1, at which a triangle is within the distance, as many steps tell:
/// never too soon. Infinity for never.
double first_near(const Triangle& triangle, const Vec3& p, const Vec3& way, double distance)
{
    constexpr int steps = 64;
    for (int i = 0; i <= steps; ++i) {
        const double part = static_cast<double>(i) / steps;
        const Vec3 at = p + part * way;
        if ((closest_point(triangle, at).point - at).norm() <= distance) return part;
        if (way.isZero()) break;
    }
    return INFINITY;
}

struct CacheCheck {
    std::uint64_t answers = 0;
    std::uint64_t given = 0;
    std::uint64_t needed = 0;
    std::uint64_t timed = 0; ///< of these, with a time
};

/// What a walk asks for, near and far, slow and fast: nothing is missing, and little is too much.
CacheCheck check_answers(const TouchMesh& named, std::uint32_t seed, int questions)
{
    const TriangleMesh& mesh = named.mesh;
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    const double size = surface.scale().extent;
    const double edge = surface.scale().mean_edge;
    ContactCache cache;
    std::vector<ContactTriangle> buffer(4096);
    std::vector<double> times(4096);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    HandPath path(mesh, seed);
    CacheCheck check;
    for (int question = 0; question < questions; ++question) {
        const Vec3 p = path.next();
        // Radii of a billionth, of a part of an edge, of a few edges; ways none, short and long.
        const double distance = std::array{1e-9 * size, 0.3 * edge * unit(random),
                                           3 * edge * unit(random)}[random() % 3];
        const double length = std::array{0.0, 1e-4 * edge, 2 * edge}[random() % 3];
        const Vec3 way =
            length * Vec3(unit(random) - 0.5, unit(random) - 0.5, random() % 4 == 0 ? 0.0 : 0.5);
        // In two parts, as who ends where something is met asks for it.
        const double part = random() % 4 == 0 ? 1 : 0.5 * unit(random);
        std::size_t soon = 0;
        std::size_t count = 0;
        if (way.isZero()) {
            soon = count = cache.collect(surface, p, distance, buffer);
            std::ranges::fill(times, 0.0);
        } else {
            cache.begin_sweep(surface, p, way, distance);
            soon = cache.next_before(surface, part, buffer, times);
            const auto left = std::span(buffer).subspan(std::min(soon, buffer.size()));
            count = soon + cache.next_before(surface, 1, left, std::span(times).subspan(soon));
            EXPECT_EQ(cache.next_before(surface, 1, buffer, times), 0U);
        }
        EXPECT_LE(count, buffer.size());
        if (count > buffer.size()) break;
        std::set<TriangleId> given;
        std::map<TriangleId, std::size_t> places;
        for (const ContactTriangle& triangle : std::span(buffer).first(count)) {
            places[triangle.id] = given.size();
            given.insert(triangle.id);
            for (int k = 0; k < 3; ++k)
                EXPECT_EQ(triangle.corners[k], mesh.triangle(triangle.id)[k]) << named.name;
        }
        EXPECT_EQ(given.size(), count) << named.name;
        ++check.answers;
        check.given += count;
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const double first = first_near(mesh.triangle(TriangleId{id}), p, way, distance);
            if (first > 1) continue;
            ++check.needed;
            const std::string what = named.name + ", seed " + std::to_string(seed) + ", question " +
                                     std::to_string(question) + ", triangle " + std::to_string(id);
            EXPECT_TRUE(given.contains(TriangleId{id})) << what;
            if (!given.contains(TriangleId{id})) continue;
            const std::size_t place = places[TriangleId{id}];
            EXPECT_LE(times[place], first) << what;
            if (first <= part) {
                EXPECT_LT(place, soon) << what;
            }
            if (times[place] > 0) ++check.timed;
        }
    }
    return check;
}

TEST(ContactCache, MissesNoNearTriangle)
{
    std::uint32_t seed = 40;
    CacheCheck sum;
    for (const TouchMesh& named : cache_meshes()) {
        const int questions = named.mesh.triangle_count() > 1000 ? 60 : 250;
        const CacheCheck check = check_answers(named, ++seed, questions);
        sum.answers += check.answers;
        sum.given += check.given;
        sum.needed += check.needed;
        sum.timed += check.timed;
    }
    EXPECT_GT(sum.needed, sum.answers);    // it was worth asking
    EXPECT_GT(20 * sum.timed, sum.needed); // with times that say something
    EXPECT_LT(sum.given, 2 * sum.needed);  // and it sorts out
}

TEST(ContactCache, KnowsTheClearanceWithoutAskingTheSurface)
{
    for (const TouchMesh& named : cache_meshes()) {
        const auto listed = testing::listed_index(named.mesh);
        const IndexContactSurface surface(*listed);
        const double edge = surface.scale().mean_edge;
        ContactCache cache;
        std::mt19937 random(7);
        std::uniform_real_distribution<double> unit(0, 1);
        HandPath path(named.mesh, 7);
        constexpr int questions = 400;
        for (int question = 0; question < questions; ++question) {
            const Vec3 p = path.next();
            const double wanted = edge * unit(random);
            const double exact = surface.clearance(p);
            const double said = cache.clearance(surface, p, wanted);
            EXPECT_LE(said, exact) << named.name;
            EXPECT_EQ(said > wanted, exact > wanted) << named.name;
            if (said <= wanted) {
                EXPECT_EQ(said, exact) << named.name;
            }
        }
        EXPECT_LT(cache.work().distances, static_cast<std::uint64_t>(questions)) << named.name;
    }
}

TEST(ContactCache, AsksTheSurfaceRarelyAlongAPath)
{
    const TriangleMesh mesh = *sample_mesh("torus:200x100");
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    const double edge = surface.scale().mean_edge;
    ContactCache cache;
    std::vector<ContactTriangle> buffer(4096);
    Vec3 p = mesh.positions()[0];
    constexpr int questions = 1000;
    for (int question = 0; question < questions; ++question) {
        p += Vec3(0, 0.05 * edge, 0);
        (void)cache.collect(surface, p, 0.1 * edge, buffer);
    }
    // The path is 50 edges long, and a ball reaches at least two edges beyond what is asked for.
    EXPECT_LE(cache.work().gathers, 1U + 25U);
    EXPECT_EQ(cache.work().scans, static_cast<std::uint64_t>(questions));
}

TEST(ContactCache, AsksANewSurfaceAgain)
{
    const TriangleMesh cube = *sample_mesh("cube");
    const TriangleMesh sphere = *sample_mesh("sphere:30x30");
    const auto cube_octree = testing::listed_index(cube);
    const auto sphere_octree = testing::listed_index(sphere);
    const IndexContactSurface first(*cube_octree);
    const IndexContactSurface second(*sphere_octree);
    const MeshContactSurface keeps_nothing(cube);
    EXPECT_NE(first.edition(), second.edition());
    EXPECT_EQ(keeps_nothing.edition(), 0U);
    ContactCache cache;
    std::vector<ContactTriangle> buffer(4096);
    const Vec3 p(0, 0, 1);
    for (int round = 0; round < 3; ++round) {
        for (const ContactSurface* surface : {static_cast<const ContactSurface*>(&first),
                                              static_cast<const ContactSurface*>(&second),
                                              static_cast<const ContactSurface*>(&keeps_nothing)}) {
            const std::size_t count = cache.collect(*surface, p, 0.01, buffer);
            const std::size_t asked = surface->collect(p, 0.01, buffer);
            EXPECT_GE(count, asked);
            EXPECT_LE(count, asked + 8);
        }
    }
}

// More triangles within what is asked for than are ever kept: the surface itself answers.
TEST(ContactCache, AnswersWhenMoreTrianglesAreNearThanItKeeps)
{
    const TriangleMesh mesh = testing::triangle_soup(5, 8000);
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    ContactCache cache;
    std::vector<ContactTriangle> buffer(8192);
    const std::size_t count = cache.collect(surface, Vec3::Zero(), 1.0, buffer);
    EXPECT_GT(count, GroupBoxes::capacity * TriangleGroup::width);
    std::set<TriangleId> given;
    for (const ContactTriangle& triangle : std::span(buffer).first(count))
        given.insert(triangle.id);
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        if (first_near(mesh.triangle(TriangleId{id}), Vec3::Zero(), Vec3::Zero(), 1.0) > 0)
            continue;
        EXPECT_TRUE(given.contains(TriangleId{id}));
    }
    (void)cache.collect(surface, Vec3::Zero(), 0.01, buffer);
    EXPECT_GT(cache.work().scans, 0U);
}

TEST(ContactCache, DoesNotAllocate)
{
    const TriangleMesh mesh = *sample_mesh("torus:24x12");
    const auto listed = testing::listed_index(mesh);
    const IndexContactSurface surface(*listed);
    ContactCache cache;
    std::vector<ContactTriangle> buffer(4096);
    std::vector<double> times(4096);
    HandPath path(mesh, 3);
    std::vector<Vec3> places;
    for (int i = 0; i < 300; ++i) places.push_back(path.next());
    const std::size_t before = testing::allocation_count();
    for (const Vec3& p : places) {
        (void)cache.collect(surface, p, 0.02, buffer);
        cache.begin_sweep(surface, p, Vec3(0.01, 0.02, 0), 0.001);
        (void)cache.next_before(surface, 0.1, buffer, times);
        (void)cache.next_before(surface, 1, buffer, times);
        (void)cache.clearance(surface, p, 0.1);
    }
    EXPECT_EQ(testing::allocation_count(), before);
}

// A hand as fast as a dash of half the model a tick, to and fro through thin walls: kept balls are
// left, met again and left out in every way, and the proxy is that of all triangles.
TEST(ContactCache, AgreesWithAllTrianglesForFastHandsOnEveryInstructionSet)
{
    for (const SimdTarget& target : simd_targets()) {
        force_simd_target(target);
        for (const TouchMesh& named : cache_meshes()) {
            if (named.mesh.triangle_count() > 500) continue;
            const auto listed = testing::listed_index(named.mesh);
            const IndexContactSurface near(*listed);
            const MeshContactSurface all(named.mesh);
            const double size = near.scale().extent;
            const ProxyOptions options = {
                .radius = 0.01 * size, .static_friction = 0.4, .dynamic_friction = 0.3};
            Proxy proxy(near, options);
            Proxy slow(all, options);
            HandPath path(named.mesh, 17);
            const Vec3 begin = path.next() + Vec3(0, 0, 2.5 * size);
            proxy.place(begin);
            slow.place(begin);
            for (int tick = 0; tick < 60; ++tick) {
                Vec3 device = path.next();
                for (int skip = 0; skip < tick % 3 * 20; ++skip) device = path.next();
                const ProxyTick& result = proxy.follow(device);
                const ProxyTick& expected = slow.follow(device);
                ASSERT_EQ(result.proxy, expected.proxy)
                    << named.name << ", " << target.name << ", tick " << tick;
                ASSERT_EQ(result.anchor, expected.anchor) << named.name << ", tick " << tick;
                ASSERT_EQ(result.moves, expected.moves) << named.name << ", tick " << tick;
            }
        }
    }
    restore_simd_targets();
}

} // namespace
} // namespace proxima::contact_cache_test
