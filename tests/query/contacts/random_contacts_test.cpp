// Contacts of random solids in random poses, against all pairs of triangles and points one by one.
#include "geometry/triangle_contact.h"
#include "oracles/exact_winding.h"
#include "oracles/nasty_corpus.h"
#include "proxima/contacts.h"
#include "proxima/sample_meshes.h"
#include "proxima/time_of_contact.h"
#include "query/contacts/lattice_hulls.h"
#include "query/contacts/random_motions.h"
#include "query/contacts/solid_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <tuple>

namespace proxima::random_contacts_test {
namespace {

using namespace testing;

/// A solid's mesh, and a vertex of each of its components.
struct RandomSolid {
    TriangleMesh mesh;
    std::vector<Vec3> of_components;

    void add(const TriangleMesh& component)
    {
        of_components.push_back(component.position(VertexId{0}));
        mesh = mesh.triangle_count() == 0 ? component : joined(mesh, component);
    }
};

TriangleMesh scaled(const TriangleMesh& mesh, double factor)
{
    return moved(mesh, [&](const Vec3& p) { return Vec3(factor * p); });
}

RandomSolid random_solid(std::mt19937_64& random, std::uint64_t kind)
{
    RandomSolid solid;
    switch (kind % 5) {
    case 0:
        solid.add(random_hull(random, 12, 1));
        break;
    case 1:
        solid.add(torus_mesh(1, 0.45, 9, 6));
        break;
    case 2: // components that reach into each other
        solid.add(random_hull(random, 8, 1));
        solid.add(moved(random_hull(random, 8, 1),
                        [](const Vec3& p) { return Vec3(p.x() + 0.9, p.y(), p.z()); }));
        break;
    case 3: // a shell with a ball in its cavity
        solid.add(make_icosphere(1));
        solid.add(scaled(inverted(make_icosphere(1)), 0.8));
        solid.add(scaled(make_icosphere(0), 0.5));
        break;
    default: // a thick bowl: a cube with a cavity near one side
        solid.add(make_cube());
        solid.add(moved(inverted(make_cube()),
                        [](const Vec3& p) { return Vec3(0.5 * p + Vec3(0.3, 0, 0.1)); }));
    }
    return solid;
}

bool has_inside(const TriangleMesh& mesh, const Vec3& p)
{
    const auto winding = oracle::exact_winding(mesh, p);
    return !winding || *winding != 0;
}

/// Whether two solids have a point in common, by all pairs of triangles and by winding numbers.
bool overlap_by_brute_force(const RandomSolid& a, const RandomSolid& b, const RigidTransform& pose)
{
    const TriangleMesh there = moved(b.mesh, [&](const Vec3& p) { return pose(p); });
    const Box box_a = bounding_box(a.mesh);
    const Box box_b = bounding_box(there);
    if ((box_a.lower.array() > box_b.upper.array()).any() ||
        (box_b.lower.array() > box_a.upper.array()).any())
        return false;
    for (std::uint32_t i = 0; i < a.mesh.triangle_count(); ++i) {
        for (std::uint32_t k = 0; k < there.triangle_count(); ++k) {
            if (triangles_meet(a.mesh.triangle(TriangleId{i}), there.triangle(TriangleId{k})))
                return true;
        }
    }
    return std::ranges::any_of(a.of_components,
                               [&](const Vec3& p) { return has_inside(there, p); }) ||
           std::ranges::any_of(b.of_components,
                               [&](const Vec3& p) { return has_inside(a.mesh, pose(p)); });
}

TEST(RandomContacts, DepthsHoldForEveryShorterTranslation)
{
    const std::uint64_t seed = 20261126;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    int overlapping = 0;
    int tried = 0;
    for (std::uint64_t i = 0; i < 50; ++i) {
        const RandomSolid mesh_a = random_solid(random, i);
        const RandomSolid mesh_b = random_solid(random, i / 5);
        const Solid a = solid_of(mesh_a.mesh);
        const Solid b = solid_of(mesh_b.mesh);
        const double apart = std::uniform_real_distribution<double>(0, 2)(random);
        const RigidTransform pose = random_pose(random, apart * random_direction(random));
        const auto found = penetration_depth(a, b, pose);
        ASSERT_TRUE(found) << i;
        const bool is_apart = found->method == PenetrationMethod::apart;
        ASSERT_EQ(overlap_by_brute_force(mesh_a, mesh_b, pose), !is_apart) << i;
        if (is_apart) continue;
        ++overlapping;
        EXPECT_LE(found->lower, found->upper) << i;
        EXPECT_LE(found->translation.norm(), found->upper * (1 + 1e-15)) << i;
        const auto overlaps_by = [&](const Vec3& translation) {
            return overlap_by_brute_force(mesh_a, mesh_b,
                                          {pose.rotation, pose.translation + translation});
        };
        EXPECT_FALSE(overlaps_by(found->translation * (1 + 1e-12))) << i;
        for (int k = 0; k < 25; ++k) {
            // The upper bound's way among them, and as far as the lower bound allows.
            const Vec3 direction = k == 0 ? found->direction : random_direction(random);
            const double part = k < 10 ? 1 - 1e-9 : std::cbrt(0.04 * k);
            EXPECT_TRUE(overlaps_by(part * found->lower * direction)) << i << ", " << k;
            ++tried;
        }
    }
    EXPECT_GT(overlapping, 30);
    EXPECT_GT(tried, 600);
}

/// Hulls with facets that hardly differ, parallel edges, or hardly any thickness.
TriangleMesh nasty_hull(std::mt19937_64& random, std::uint64_t kind)
{
    if (kind % 4 == 0) return random_hull(random, 10, 1);
    std::vector<Vec3> points;
    const auto whole = [&] { return static_cast<double>(random() % 4U); };
    for (int i = 0; i < 14; ++i) {
        const Vec3 p = Vec3(whole(), whole(), whole());
        points.push_back(kind % 4 == 1   ? p
                         : kind % 4 == 2 ? Vec3(p.x(), p.y(), 1e-5 * p.z())
                                         : Vec3(1e-4 * p.x(), 1e-4 * p.y(), p.z() + 0.1 * p.x()));
    }
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}) {
        points.push_back(kind % 4 == 2   ? Vec3(p.x(), p.y(), 1e-5 * p.z())
                         : kind % 4 == 3 ? Vec3(1e-4 * p.x(), 1e-4 * p.y(), p.z())
                                         : p);
    }
    return surface_of(convex_hull(points).value());
}

TEST(RandomContacts, DepthsOfHullsAreThoseOfAllNormals)
{
    const std::uint64_t seed = 68;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    int overlapping = 0;
    for (std::uint64_t i = 0; i < 240; ++i) {
        const TriangleMesh mesh_a = nasty_hull(random, i);
        const TriangleMesh mesh_b = nasty_hull(random, i / 4);
        const Solid a = solid_of(mesh_a);
        const Solid b = solid_of(mesh_b);
        ASSERT_TRUE(a.is_convex() && b.is_convex()) << i;
        const auto part = std::uniform_real_distribution<double>(0, 1.2)(random);
        RigidTransform pose = random_pose(random, Vec3::Zero());
        if (i % 3 == 0) pose.rotation = Mat3::Identity(); // parallel faces
        const Vec3 inner_b = pose(bounding_box(mesh_b).center());
        const Vec3 from = bounding_box(mesh_a).center() - inner_b;
        const double size =
            std::min(bounding_box(mesh_a).extent().norm(), bounding_box(mesh_b).extent().norm());
        pose.translation += from + 0.5 * part * size * random_direction(random);
        const auto found = penetration_depth(a, b, pose);
        ASSERT_TRUE(found) << i;
        if (found->method == PenetrationMethod::apart) continue;
        ++overlapping;
        const long double truth = convex_depth_by_brute_force(mesh_a, mesh_b, pose);
        EXPECT_LE(found->lower, truth) << i;
        EXPECT_GE(found->upper, truth) << i;
        EXPECT_LT(found->upper - found->lower, 2 * (a.hull_error() + b.hull_error()) + 2e-12) << i;
        EXPECT_FALSE(solids_overlap(a, b, {pose.rotation, pose.translation + found->translation}));
    }
    EXPECT_GT(overlapping, 150);
}

/// Length and middle of what connected lines of a contour are together.
struct BruteRegion {
    double length = 0;
    Vec3 weighted = Vec3::Zero();
};

/// Regions of meshes in general position: each pair of triangles that meet has a segment, whose ends are edges of one
/// and a triangle of the other; segments with an end in common are connected.
std::vector<BruteRegion> regions_by_brute_force(const TriangleMesh& a, const TriangleMesh& b)
{
    using End = std::tuple<bool, std::uint32_t, std::uint32_t,
                           std::uint32_t>; // whose edge, its vertices, triangle
    struct Segment {
        std::vector<Vec3> points;
        std::size_t region;
    };
    std::vector<Segment> segments;
    std::map<End, std::size_t> first_with;
    std::vector<std::size_t> joined_to;
    const auto root = [&](std::size_t i) {
        while (joined_to[i] != i) i = joined_to[i];
        return i;
    };
    const auto add_ends = [&](const TriangleMesh& edges, std::uint32_t of_edges,
                              const TriangleMesh& faces, std::uint32_t of_faces, bool is_a) {
        const TriangleCorners& corners = edges.triangles()[of_edges];
        const Triangle face = faces.triangle(TriangleId{of_faces});
        const Vec3 normal = (face[1] - face[0]).cross(face[2] - face[0]);
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [u, v] = std::minmax(corners[i], corners[(i + 1) % 3]);
            const Vec3 p = edges.position(VertexId{u});
            const Vec3 q = edges.position(VertexId{v});
            if (!segment_meets_triangle(p, q, face)) continue;
            const double from = normal.dot(p - face[0]);
            segments.back().points.push_back(p + from / (from - normal.dot(q - face[0])) * (q - p));
            const auto [at, is_new] =
                first_with.insert({{is_a, u, v, of_faces}, segments.size() - 1});
            if (!is_new) joined_to[root(segments.size() - 1)] = root(at->second);
        }
    };
    for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
        for (std::uint32_t k = 0; k < b.triangle_count(); ++k) {
            if (!triangles_meet(a.triangle(TriangleId{i}), b.triangle(TriangleId{k}))) continue;
            segments.push_back({});
            joined_to.push_back(segments.size() - 1);
            add_ends(a, i, b, k, true);
            add_ends(b, k, a, i, false);
        }
    }
    std::map<std::size_t, BruteRegion> regions;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const auto& points = segments[i].points;
        EXPECT_EQ(points.size(), 2U) << "not in general position";
        if (points.size() != 2) continue;
        const double length = (points[1] - points[0]).norm();
        BruteRegion& region = regions[root(i)];
        region.length += length;
        region.weighted += length * 0.5 * (points[0] + points[1]);
    }
    std::vector<BruteRegion> all;
    for (const auto& [number, region] : regions) all.push_back(region);
    return all;
}

TEST(RandomContacts, RegionsAreThoseOfAllPairsOfTriangles)
{
    const std::uint64_t seed = 574;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    std::size_t regions = 0;
    int several = 0;
    for (std::uint64_t i = 0; i < 60; ++i) {
        const RandomSolid mesh_a = random_solid(random, i);
        const RandomSolid mesh_b = random_solid(random, i / 5);
        const double apart = std::uniform_real_distribution<double>(0.3, 2)(random);
        const RigidTransform pose = random_pose(random, apart * random_direction(random));
        const auto found = contact_regions(solid_of(mesh_a.mesh), solid_of(mesh_b.mesh), pose);
        ASSERT_TRUE(found) << i;
        std::vector<BruteRegion> truth = regions_by_brute_force(
            mesh_a.mesh, moved(mesh_b.mesh, [&](const Vec3& p) { return pose(p); }));
        ASSERT_EQ(found->regions.size(), truth.size()) << i;
        std::vector<ContactRegion> sorted = found->regions;
        std::ranges::sort(sorted, {}, &ContactRegion::length);
        std::ranges::sort(truth, {}, &BruteRegion::length);
        for (std::size_t k = 0; k < truth.size(); ++k) {
            EXPECT_NEAR(sorted[k].length, truth[k].length, 1e-9) << i;
            EXPECT_LT((sorted[k].position - truth[k].weighted / truth[k].length).norm(), 1e-6) << i;
        }
        regions += truth.size();
        several += truth.size() > 1 ? 1 : 0;
    }
    EXPECT_GT(regions, 50U);
    EXPECT_GT(several, 10);
}

TEST(RandomContacts, RegionsOfLinesThatMeetAreJoined)
{
    const std::uint64_t seed = 491;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    int cases = 0;
    int joined_regions = 0;
    int reduced = 0;
    for (int i = 0; i < 3000; ++i) {
        TriangleMesh a = lattice_hull(random);
        if (i % 2 == 0) {
            a = joined(a, moved(lattice_hull(random),
                                [](const Vec3& p) { return Vec3(p + Vec3(5, 0, 0)); }));
        }
        const double wide = i % 2 == 0 ? 2 : 1;
        const auto shift = [&] { return static_cast<double>(random() % 5U) - 2; };
        const Vec3 by(shift(), shift(), shift());
        const TriangleMesh b = moved(lattice_hull(random), [&](const Vec3& p) {
            return Vec3(Vec3(wide * p.x(), p.y(), p.z()) + by);
        });
        const auto segments = segments_by_brute_force(a, b);
        if (!segments || segments->empty()) continue;
        ++cases;
        const auto found = contact_regions(solid_of(a), solid_of(b));
        ASSERT_TRUE(found) << i;
        std::vector<double> lengths;
        for (const ContactRegion& region : found->regions) {
            lengths.push_back(region.length);
            joined_regions += region.line_count > 1 ? 1 : 0;
            const auto points = region.contacts();
            ASSERT_GE(points.size(), 1U) << i;
            ASSERT_LE(points.size(), max_contact_points) << i;
            reduced += points.size() == max_contact_points ? 1 : 0;
            EXPECT_GE(points.front().depth, (1 - 0x1p-20) * region.depth) << i;
            for (std::size_t k = 0; k < points.size(); ++k) {
                EXPECT_LE(points[k].depth, region.depth) << i;
                for (std::size_t m = 0; m < k; ++m) {
                    EXPECT_GT((points[k].on_a - points[m].on_a).norm() +
                                  (points[k].on_b - points[m].on_b).norm(),
                              0)
                        << i;
                }
            }
        }
        std::ranges::sort(lengths);
        const std::vector<double> truth = connected_lengths(*segments);
        ASSERT_EQ(lengths.size(), truth.size()) << i;
        for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(lengths[k], truth[k], 1e-9) << i;
    }
    EXPECT_GT(cases, 300);
    EXPECT_GT(joined_regions, 30);
    EXPECT_GT(reduced, 100);
}

TEST(RandomContacts, TimesOfNastyMeshesAreNeverPastAContact)
{
    const std::uint64_t seed = 555;
    SCOPED_TRACE(seed);
    int contacts = 0;
    int free = 0;
    std::uint64_t number = 0;
    for (const oracle::NastyMesh& nasty : oracle::nasty_corpus(24)) {
        SCOPED_TRACE(nasty.name);
        const MeshIndex plain = build_mesh_index(nasty.mesh).value();
        const MeshIndex slabs = with_slabs(plain).value();
        MotionGenerator motions(nasty.mesh, nasty.mesh, seed + number++);
        for (int i = 0; i < 6; ++i) {
            const RigidMotion motion = motions();
            const MeshIndex& index = i % 2 == 0 ? plain : slabs;
            const auto found = time_of_contact(index, index, motion);
            const double end = found ? found->free_until : 1;
            constexpr int steps = 60;
            for (int k = 0; k <= steps && (!found || found->touches_at > 0); ++k) {
                const double time = end * k / steps;
                ASSERT_FALSE(meshes_intersect(index, index, pose_at(motion, time)))
                    << i << ", " << time;
            }
            if (found && found->evidence == ContactEvidence::intersection) {
                EXPECT_TRUE(meshes_intersect(index, index, pose_at(motion, found->touches_at)))
                    << i;
            }
            (found ? contacts : free) += 1;
        }
    }
    EXPECT_GT(contacts, 100);
    EXPECT_GT(free, 50);
}

} // namespace
} // namespace proxima::random_contacts_test
