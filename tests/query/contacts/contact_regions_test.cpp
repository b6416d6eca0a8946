#include "cancellation.h"
#include "code_of.h"
#include "proxima/contacts.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/minkowski_sum.h"
#include "proxima/sample_meshes.h"
#include "proxima/signed_distance.h"
#include "query/contact/find_pairs.h"
#include "query/contacts/random_motions.h"
#include "query/contacts/solid_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

namespace proxima::contact_regions_test {
namespace {

using namespace testing;

RigidTransform placed(const Vec3& translation)
{
    RigidTransform pose;
    pose.translation = translation;
    return pose;
}

ContactRegions regions_of(const Solid& a, const Solid& b, const RigidTransform& pose = {})
{
    return contact_regions(a, b, pose).value();
}

/// What every region promises.
void expect_sound(const Solid& a, const Solid& b, const RigidTransform& pose,
                  const ContactRegions& found)
{
    std::size_t lines = 0;
    for (const ContactRegion& region : found.regions) {
        EXPECT_NEAR(region.normal.norm(), 1, 1e-12);
        EXPECT_EQ(region.first_line, lines);
        lines += region.line_count;
        ASSERT_GE(region.point_count, 1U);
        ASSERT_LE(region.point_count, max_contact_points);
        EXPECT_GE(region.contacts().front().depth, (1 - 0x1p-20) * region.depth);
        for (const RegionPoint& point : region.contacts()) {
            EXPECT_LE(point.depth, region.depth);
            EXPECT_GE(point.depth, 0);
            EXPECT_NEAR((point.on_a - point.on_b).dot(region.normal), point.depth, 1e-12);
            // Between the two the line is in both.
            const RigidTransform back = pose.inverse();
            for (const double part : {0.01, 0.5, 0.99}) {
                const Vec3 p = point.on_b + part * (point.on_a - point.on_b);
                if (point.depth < 1e-9) continue;
                EXPECT_LE(signed_distance(a.index(), p)->distance, 1e-12);
                EXPECT_LE(signed_distance(b.index(), back(p))->distance, 1e-12);
            }
        }
    }
    EXPECT_EQ(lines, found.contour.lines.size());
}

TEST(ContactRegions, OfABoxInAFloorHaveFourCornersAndTheDepth)
{
    const Solid floor = solid_of(box_mesh({Vec3(-8, -8, -2), Vec3(8, 8, 0)}));
    const Solid box = solid_of(box_mesh({Vec3(-1, -2, -1), Vec3(1, 2, 1)}));
    for (const double depth : {0.125, 1e-3, 1e-6}) {
        RigidTransform pose;
        pose.rotation = Eigen::AngleAxisd(0.3, Vec3::UnitZ()).toRotationMatrix();
        pose.translation = Vec3(1, 2, 1 - depth);
        const ContactRegions found = regions_of(floor, box, pose);
        ASSERT_EQ(found.regions.size(), 1U);
        const ContactRegion& region = found.regions.front();
        expect_sound(floor, box, pose, found);
        EXPECT_NEAR((region.normal - Vec3::UnitZ()).norm(), 0, 1e-9);
        EXPECT_NEAR((region.position - Vec3(1, 2, 0)).norm(), 0, 1e-9);
        EXPECT_NEAR(region.depth, depth, 1e-9);
        EXPECT_NEAR(region.length, 12, 1e-9);
        EXPECT_NEAR(region.area, 8, 1e-9);
        ASSERT_EQ(region.point_count, 4U);
        double area = 0;
        const Vec3 first = region.points[0].on_a;
        for (const RegionPoint& point : region.contacts()) {
            for (const RegionPoint& other : region.contacts())
                area = std::max(area, (point.on_a - first).cross(other.on_a - first).norm());
        }
        EXPECT_GT(area, 0.8 * 8) << "the points reach to the corners";
    }
}

/// The area of the hull of four points in a plane: each point of it is in two of their four triangles.
double hull_area(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    const auto twice = [](const Vec3& p, const Vec3& q, const Vec3& r) {
        return (q - p).cross(r - p).norm();
    };
    return 0.25 * (twice(a, b, c) + twice(a, b, d) + twice(a, c, d) + twice(b, c, d));
}

TEST(ContactRegions, OfPrismsInAFloorAreTheFarthestOfTheirCorners)
{
    const std::uint64_t seed = 41;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const Solid floor = solid_of(box_mesh({Vec3(-40, -40, -2), Vec3(40, 40, 0)}));
    int compared = 0;
    for (int i = 0; i < 100; ++i) {
        SCOPED_TRACE(i);
        // Five corners on an ellipse somewhere in the floor.
        std::vector<Vec3> corners;
        const Vec3 middle(30 * unit(random) - 15, 30 * unit(random) - 15, 0);
        for (int k = 0; k < 5; ++k) {
            const double turn = 2 * std::numbers::pi * (k + 0.9 * unit(random)) / 5;
            corners.push_back(middle + Vec3(2 * std::cos(turn), std::sin(turn), 0));
        }
        std::vector<Vec3> points;
        for (const Vec3& corner : corners)
            for (const double z : {-0.125, 1.0}) points.emplace_back(corner.x(), corner.y(), z);
        const Solid prism = solid_of(surface_of(convex_hull(points).value()));
        const ContactRegions found = regions_of(floor, prism);
        ASSERT_EQ(found.regions.size(), 1U);
        const ContactRegion& region = found.regions.front();
        expect_sound(floor, prism, {}, found);
        EXPECT_NEAR(region.depth, 0.125, 1e-9);
        double length = 0;
        Vec3 weighted = Vec3::Zero();
        for (std::size_t k = 0; k < 5; ++k) {
            const Vec3& next = corners[(k + 1) % 5];
            length += (next - corners[k]).norm();
            weighted += (next - corners[k]).norm() * 0.5 * (next + corners[k]);
        }
        EXPECT_NEAR((region.position - weighted / length).norm(), 0, 1e-9);
        // Each point is the corner that is best for it, if one is clearly better than all others.
        std::array<Vec3, 4> best;
        bool is_clear = true;
        const auto choose = [&](std::size_t k, const auto& measure) {
            std::ranges::sort(corners, std::greater(), measure);
            best[k] = corners[0];
            is_clear = is_clear && measure(corners[1]) < 0.96 * measure(corners[0]);
        };
        choose(0, [&](const Vec3& p) { return (p - region.position).norm(); });
        choose(1, [&](const Vec3& p) { return (p - best[0]).norm(); });
        choose(2, [&](const Vec3& p) { return (p - best[0]).cross(best[1] - best[0]).norm(); });
        const double area = hull_area(best[0], best[1], best[2], best[0]);
        choose(3, [&](const Vec3& p) { return hull_area(best[0], best[1], best[2], p) - area; });
        if (!is_clear) continue;
        ++compared;
        ASSERT_EQ(region.point_count, 4U);
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3 on_floor(region.points[k].on_a.x(), region.points[k].on_a.y(), 0);
            EXPECT_LT((on_floor - best[k]).norm(), 0.1) << k;
        }
    }
    EXPECT_GT(compared, 10);
}

TEST(ContactRegions, OfBoxesBesideEachOtherFaceAsTheirFacesDo)
{
    // The contour runs up and down the sides: the plane that it spans is slanting.
    const Solid cube = solid_of(make_cube());
    RigidTransform pose;
    pose.rotation = Eigen::AngleAxisd(0.35, Vec3::UnitZ()).toRotationMatrix();
    pose.translation = Vec3(0.3, 0.4, 1.9);
    const ContactRegions found = regions_of(cube, cube, pose);
    ASSERT_EQ(found.regions.size(), 1U);
    expect_sound(cube, cube, pose, found);
    EXPECT_NEAR((found.regions[0].normal - Vec3::UnitZ()).norm(), 0, 1e-12);
    EXPECT_NEAR(found.regions[0].depth, 0.1, 1e-12);
    EXPECT_EQ(found.regions[0].point_count, 4U);
}

TEST(ContactRegions, OfFlushBoxesFaceAcrossTheLeastDepth)
{
    const Solid cube = solid_of(make_cube());
    const struct {
        Box box;
        Vec3 shift;
        Vec3 normal;
        double depth;
    } cases[] = {
        {{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, Vec3(0, 0, 1.9), Vec3::UnitZ(), 0.1},   // four sides
        {{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, Vec3(0, 0.5, 1.9), Vec3::UnitZ(), 0.1}, // two
        {{Vec3(-1, -0.5, -1), Vec3(1, 1, 1)}, Vec3(0, 0, 1.9), Vec3::UnitZ(), 0.1}, // three
        {{Vec3(-1, -0.5, -1), Vec3(0.5, 1, 1)}, Vec3(0, 0, -1.9), -Vec3::UnitZ(), 0.1},      // two
        {{Vec3(-1, -1, -1), Vec3(1, 1, 1)}, Vec3(1.99, 0, 0), Vec3::UnitX(), 0.01},          // four
        {{Vec3(-1, -0.5, -0.5), Vec3(1, 0.5, 0.5)}, Vec3(1.99, 0.5, 0), Vec3::UnitX(), 0.01} // one
    };
    for (const auto& [box, shift, normal, depth] : cases) {
        const Solid other = solid_of(box_mesh(box));
        const RigidTransform pose = placed(shift);
        const ContactRegions found = regions_of(cube, other, pose);
        ASSERT_EQ(found.regions.size(), 1U) << shift.transpose();
        expect_sound(cube, other, pose, found);
        EXPECT_NEAR((found.regions[0].normal - normal).norm(), 0, 1e-9) << shift.transpose();
        EXPECT_NEAR(found.regions[0].depth, depth, 1e-9) << shift.transpose();
    }
}

/// A box of slices along y, which all have their own triangles at its four sides.
TriangleMesh sliced_box(const Box& box, std::uint32_t slices)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    const auto square = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
    };
    for (std::uint32_t i = 0; i <= slices; ++i) {
        const double y = box.lower.y() + i * (box.extent().y() / slices);
        positions.emplace_back(box.lower.x(), y, box.lower.z());
        positions.emplace_back(box.upper.x(), y, box.lower.z());
        positions.emplace_back(box.upper.x(), y, box.upper.z());
        positions.emplace_back(box.lower.x(), y, box.upper.z());
        if (i == 0) continue;
        const std::uint32_t at = 4 * (i - 1);
        for (std::uint32_t k = 0; k < 4; ++k)
            square(at + k, at + 4 + k, at + 4 + (k + 1) % 4, at + (k + 1) % 4);
    }
    const std::uint32_t end = 4 * slices;
    square(0, 1, 2, 3);
    square(end, end + 3, end + 2, end + 1);
    return mesh_of(std::move(positions), std::move(triangles));
}

void expect_same(const ContactRegion& one, const ContactRegion& other, const Vec3& shift)
{
    EXPECT_NEAR((one.position + shift - other.position).norm(), 0, 1e-9);
    EXPECT_NEAR((one.normal - other.normal).norm(), 0, 1e-9);
    EXPECT_NEAR(one.depth, other.depth, 1e-9);
    EXPECT_NEAR(one.length, other.length, 1e-9);
    EXPECT_EQ(one.point_count, other.point_count);
}

TEST(ContactRegions, OfOneOfManyThatAreFlushAreThoseOfItAlone)
{
    // A bar on the edge of a plate, its side flush with the plate's, and pins that stand on the plate.
    const Solid plate = solid_of(box_mesh({Vec3(-1, -1, -1), Vec3(41, 41, 0)}));
    const TriangleMesh bar = sliced_box({Vec3(-1, 1, -0.125), Vec3(0, 35, 1)}, 272);
    const TriangleMesh pin = box_mesh({Vec3(2, 0, 0), Vec3(3, 1, 1)});
    const ContactRegions of_bar = regions_of(plate, solid_of(bar));
    ASSERT_EQ(of_bar.regions.size(), 1U);
    EXPECT_NEAR((of_bar.regions[0].normal - Vec3::UnitZ()).norm(), 0, 1e-9);
    EXPECT_NEAR(of_bar.regions[0].depth, 0.125, 1e-9);
    const ContactRegions of_pin = regions_of(plate, solid_of(pin));
    ASSERT_EQ(of_pin.regions.size(), 1U);
    TriangleMesh all = bar;
    std::vector<Vec3> shifts;
    for (int i = 0; i < 18; ++i) {
        for (int j = 0; j < 20; ++j) {
            const Vec3 shift(2 * i, 2 * j, 0);
            shifts.push_back(shift);
            all = joined(all, moved(pin, [&](const Vec3& p) { return Vec3(p + shift); }));
        }
    }
    const Solid many = solid_of(all);
    const ContactRegions found = regions_of(plate, many);
    expect_sound(plate, many, {}, found);
    ASSERT_EQ(found.regions.size(), 1 + shifts.size());
    std::vector<ContactRegion> regions = found.regions;
    const auto longest = std::ranges::max_element(regions, {}, &ContactRegion::length);
    expect_same(of_bar.regions[0], *longest, Vec3::Zero());
    regions.erase(longest);
    for (const ContactRegion& region : regions) {
        const Vec3& there = region.position;
        const auto nearest = std::ranges::min_element(shifts, {}, [&](const Vec3& shift) {
            return (of_pin.regions[0].position + shift - there).norm();
        });
        expect_same(of_pin.regions[0], region, *nearest);
        shifts.erase(nearest);
    }
    // The other way round the many triangles are A's.
    const ContactRegions back = regions_of(many, plate);
    ASSERT_EQ(back.regions.size(), found.regions.size());
    for (const ContactRegion& region : back.regions)
        EXPECT_NEAR((region.normal + Vec3::UnitZ()).norm(), 0, 1e-9);
}

TEST(ContactRegions, OfFlushFacesThatAreCutDifferentlyAreOne)
{
    // The diagonal of the plate's face crosses the edges between the bar's slices.
    const Solid plate = solid_of(box_mesh({Vec3(-4, -4, -1), Vec3(4, 4, 0)}));
    for (const double low : {0.0, -0.5}) {
        const TriangleMesh mesh = sliced_box({Vec3(-1, -2, low), Vec3(1, 2, low + 0.5)}, 8);
        const Solid bar = solid_of(mesh);
        const ContactRegions found = regions_of(plate, bar);
        expect_sound(plate, bar, {}, found);
        ASSERT_EQ(found.regions.size(), 1U) << low;
        EXPECT_EQ(found.regions[0].length, 12);
        EXPECT_NEAR((found.regions[0].normal - Vec3::UnitZ()).norm(), 0, 1e-9);
        EXPECT_NEAR(found.regions[0].depth, -low, 1e-9);
        EXPECT_EQ(found.regions[0].point_count, 4U);
    }
}

TEST(ContactRegions, OfPosesThatAreNoRotationAreThoseOfTheMovedVertices)
{
    const Solid cube = solid_of(make_cube());
    const Solid far = solid_of(box_mesh({Vec3(1000, -0.5, -0.5), Vec3(1001, 0.5, 0.5)}));
    for (const double off : {2.8e-10, -2.8e-10}) {
        RigidTransform pose = placed(Vec3(-1000 + 0.99, 0, 0));
        pose.rotation *= 1 + off;
        const ContactRegions found = regions_of(cube, far, pose);
        ASSERT_EQ(found.regions.size(), 1U);
        EXPECT_NEAR(found.regions[0].depth, 1 - pose(Vec3(1000, 0, 0)).x(), 1e-12);
    }
}

TEST(ContactRegions, RefusePosesThatAreNone)
{
    const Solid cube = solid_of(make_cube());
    for (const double bad : {HUGE_VAL, std::nan("")}) {
        EXPECT_EQ(code_of(contact_regions(cube, cube, placed(Vec3(0, bad, 0)))),
                  ErrorCode::invalid_argument);
    }

    Progress progress;
    progress.cancel();
    EXPECT_EQ(code_of(contact_regions(cube, cube, {}, {.execution = {.progress = &progress}})),
              ErrorCode::cancelled);
}

TEST(ContactRegions, AreCancelledAtEveryStage)
{
    const Solid ball = solid_of(make_icosphere(4));
    const Solid torus = solid_of(make_torus(64, 32));
    cancel_at_every_stage(
        [&](Progress& progress) {
            return contact_regions(ball, torus, {}, {.execution = {.progress = &progress}});
        },
        [] { return true; });
}

TEST(ContactRegions, AreCancelledWithinARegion)
{
    // Flush slices that cross: most of the region's work goes into their pairs of triangles.
    const Solid a = solid_of(sliced_box({Vec3(-1, -1, -1), Vec3(1, 1, 0)}, 60));
    const Solid b = solid_of(sliced_box({Vec3(-0.9, -0.8, 0), Vec3(0.9, 0.8, 1)}, 60));
    RigidTransform pose;
    pose.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    // Cancelled at each report; within the region is the one at half of the stage.
    bool was_within = false;
    bool is_done = false;
    for (std::uint64_t reports = 1; !is_done; ++reports) {
        Progress progress;
        progress.cancel_after(reports);
        is_done = contact_regions(a, b, pose, {.execution = {.progress = &progress}}).has_value();
        if (progress.fraction() != 0.5 ||
            progress.stage() != std::string_view("measuring contact regions"))
            continue;
        EXPECT_FALSE(is_done);
        was_within = true;
    }
    EXPECT_TRUE(was_within);
    Progress stopped;
    stopped.cancel();
    const std::size_t all = find_pairs(a.index(), b.index(), pose, nullptr).size();
    EXPECT_LT(10 * find_pairs(a.index(), b.index(), pose, &stopped).size(), all);
}

TEST(ContactRegions, OfTwoBallsAreTheLens)
{
    const Solid ball = solid_of(make_icosphere(4));
    std::mt19937_64 random(5);
    for (int i = 0; i < 6; ++i) {
        const Vec3 apart = 1.6 * random_direction(random);
        const RigidTransform pose = random_pose(random, apart);
        const ContactRegions found = regions_of(ball, ball, pose);
        ASSERT_EQ(found.regions.size(), 1U);
        expect_sound(ball, ball, pose, found);
        const ContactRegion& region = found.regions.front();
        EXPECT_LT((region.normal - apart.normalized()).norm(), 0.01);
        EXPECT_LT((region.position - 0.5 * apart).norm(), 0.01);
        EXPECT_NEAR(region.depth, 0.4, 0.01);
        EXPECT_NEAR(region.length, 2 * std::numbers::pi * 0.6, 0.03);
        EXPECT_EQ(region.point_count, 4U);
    }
}

TEST(ContactRegions, OfConvexBodiesAreAsDeepAsTheirSumSays)
{
    const std::uint64_t seed = 31;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    int compared = 0;
    double worst = 0;
    for (int i = 0; i < 40; ++i) {
        const TriangleMesh mesh_a = random_hull(random, 12 + i, 1);
        const TriangleMesh mesh_b = random_hull(random, 10 + i, 1);
        const RigidTransform pose = random_pose(random, 1.4 * random_direction(random));
        const Solid a = solid_of(mesh_a);
        const Solid b = solid_of(mesh_b);
        const ContactRegions found = regions_of(a, b, pose);
        expect_sound(a, b, pose, found);
        if (found.regions.size() != 1) continue;
        // The longest piece of a line in what they have in common: how far that moves along the
        // line until it is free of itself.
        std::vector<Vec3> moved_points;
        for (const Vec3& p : mesh_b.positions()) moved_points.push_back(pose(p));
        std::vector<HalfSpace> planes;
        for (const auto& hull : {convex_hull(mesh_a.positions()), convex_hull(moved_points)}) {
            for (std::uint32_t f = 0; f < hull->facet_count(); ++f)
                planes.push_back(hull->half_space(f));
        }
        const auto common = polyhedron_of_half_spaces(planes);
        if (!common) continue;
        const auto sum = minkowski_sum(*common, mirrored(*common));
        const auto depth =
            directional_depth(sum.value(), Vec3::Zero(), found.regions.front().normal);
        ASSERT_TRUE(depth);
        EXPECT_LE(found.regions.front().depth, *depth * (1 + 1e-9) + 1e-12) << i;
        worst = std::max(worst, 1 - found.regions.front().depth / *depth);
        ++compared;
    }
    EXPECT_GT(compared, 15);
    EXPECT_LT(worst, 0.02);
}

TEST(ContactRegions, OfABarThroughAPlateFaceBothWays)
{
    const Solid plate = solid_of(box_mesh({Vec3(-4, -4, -0.5), Vec3(4, 4, 0.5)}));
    const Solid bar = solid_of(box_mesh({Vec3(-0.25, -0.25, -3), Vec3(0.25, 0.25, 3)}));
    const ContactRegions found = regions_of(plate, bar);
    ASSERT_EQ(found.regions.size(), 2U);
    expect_sound(plate, bar, {}, found);
    EXPECT_NEAR(found.regions[0].normal.dot(found.regions[1].normal), -1, 1e-12);
    for (const ContactRegion& region : found.regions) {
        EXPECT_NEAR(region.position.dot(region.normal), 0.5, 1e-12) << "outward, at its face";
        EXPECT_NEAR(region.depth, 1, 1e-9);
    }
}

TEST(ContactRegions, OfATorusOnAFloorGoRoundTheHole)
{
    const Solid floor = solid_of(box_mesh({Vec3(-8, -8, -2), Vec3(8, 8, 0)}));
    const Solid torus = solid_of(make_torus(64, 32));
    const RigidTransform pose = placed(Vec3(0.3, 0.2, 0.49));
    const ContactRegions found = regions_of(floor, torus, pose);
    ASSERT_EQ(found.regions.size(), 2U);
    expect_sound(floor, torus, pose, found);
    for (const ContactRegion& region : found.regions) {
        EXPECT_NEAR((region.normal - Vec3::UnitZ()).norm(), 0, 1e-6);
        EXPECT_LE(region.depth, 0.01 + 1e-12);
        EXPECT_GT(region.depth, 0.009);
        EXPECT_EQ(region.point_count, 4U);
    }
}

TEST(ContactRegions, OfACornerThatPeepsOutEnd)
{
    // Three of the four tetrahedra of A reach into B, and one of its corners is all but in B's face: that
    // region's contour is 1e-13 long, and deeper lines are a million millions of its lengths away.
    std::vector<Vec3> positions = {
        {0.25, 0.125, 0.5},   {0.875, 0, 0.25}, {0.375, 0, 0.5},   {0, 0, 0.875},
        {0, 0, 0.375},        {0.875, 1, 0},    {0, -1, 0},        {0, 0, 1},
        {0.625, 0.125, 0.25}, {0.375, 0, 6.25}, {0.875, 0, 0.375}, {0, 0.25, 0.5},
        {0.125, 0.5, 0.5},    {0, 0.5, 0},      {0, 0.875, 0},     {0, 0.375, 0.875}};
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t at = 0; at < 16; at += 4) {
        for (const TriangleCorners& c : {TriangleCorners{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}})
            triangles.push_back({at + c[0], at + c[1], at + c[2]});
    }
    const Solid a = solid_of(make_triangle_mesh(positions, triangles).value());
    const Solid b =
        solid_of(make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {1, 0, 0.625}, {0.25, 0.625, 0.375}},
                                    {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}})
                     .value());
    const RigidTransform pose = {
        Eigen::AngleAxisd(108.78842085288763 * std::numbers::pi / 180,
                          Vec3(0.64270151132237585, 0.43714238200575201, 0.62915920496983224))
            .toRotationMatrix(),
        Vec3(-0.24546127157795689, 0.23124853654234245, 0.0017055380423582345)};
    const ContactRegions found = regions_of(a, b, pose);
    expect_sound(a, b, pose, found);
    const auto least = std::ranges::min_element(found.regions, {}, &ContactRegion::length);
    EXPECT_LT(least->length, 1e-12);
    EXPECT_GT(least->depth, 0.1);
}

TEST(ContactRegions, OfATouchHaveNoDepth)
{
    const Solid cube = solid_of(make_cube());
    const Solid corners = solid_of(make_octahedron());
    const RigidTransform pose = placed(Vec3(0, 0, 2));
    const ContactRegions found = regions_of(cube, corners, pose);
    ASSERT_EQ(found.regions.size(), 1U);
    const ContactRegion& region = found.regions.front();
    EXPECT_EQ(region.depth, 0);
    EXPECT_EQ(region.length, 0);
    ASSERT_EQ(region.point_count, 1U);
    EXPECT_NEAR((region.points[0].on_a - Vec3(0, 0, 1)).norm(), 0, 1e-15);
    EXPECT_NEAR((region.position - Vec3(0, 0, 1)).norm(), 0, 1e-15);
    EXPECT_GT(region.normal.z(), 0.5);
    for (const Vec3& side : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, -1)}) {
        const ContactRegions other = regions_of(cube, corners, placed(2 * side));
        ASSERT_EQ(other.regions.size(), 1U);
        EXPECT_GT(other.regions.front().normal.dot(side), 0.5);
    }
    const ContactRegions faces = regions_of(cube, cube, placed(Vec3(2, 0.5, 0)));
    ASSERT_EQ(faces.regions.size(), 1U);
    EXPECT_LT(faces.regions[0].depth, 1e-12);
    EXPECT_NEAR((faces.regions[0].normal - Vec3::UnitX()).norm(), 0, 1e-9);
    EXPECT_EQ(faces.regions[0].point_count, 4U);
}

TEST(ContactRegions, OfMeshesApartOrInsideAreNone)
{
    const Solid large = solid_of(box_mesh({Vec3(-4, -4, -4), Vec3(4, 4, 4)}));
    const Solid cube = solid_of(make_cube());
    EXPECT_TRUE(regions_of(large, cube).regions.empty());
    EXPECT_TRUE(regions_of(large, cube, placed(Vec3(9, 0, 0))).regions.empty());
}

TEST(ContactRegions, OfRandomPosesAreSound)
{
    const std::uint64_t seed = 99;
    std::mt19937_64 random(seed);
    SCOPED_TRACE(seed);
    const Solid ship = solid_of(sample_mesh("spaceship:1300").value());
    const Solid torus = solid_of(make_torus(24, 12));
    std::size_t regions = 0;
    for (int i = 0; i < 20; ++i) {
        const RigidTransform pose = random_pose(random, random_direction(random));
        const ContactRegions found = regions_of(ship, torus, pose);
        expect_sound(ship, torus, pose, found);
        regions += found.regions.size();
    }
    EXPECT_GT(regions, 20U);
}

TEST(ContactRegions, MoveWithTheMeshes)
{
    std::mt19937_64 random(17);
    const TriangleMesh mesh = make_torus(24, 12);
    const Solid torus = solid_of(mesh);
    const Solid ball = solid_of(make_icosphere(3));
    const RigidTransform pose = random_pose(random, Vec3(1.2, 0.5, 0.4));
    const ContactRegions plain = regions_of(torus, ball, pose);
    const RigidTransform turned = random_pose(random, Vec3(3, -2, 1));
    RigidTransform together = turned;
    together.rotation = turned.rotation * pose.rotation;
    together.translation = turned(pose.translation);
    const ContactRegions there =
        regions_of(solid_of(moved(mesh, [&](const Vec3& p) { return turned(p); })), ball, together);
    ASSERT_EQ(plain.regions.size(), there.regions.size());
    ASSERT_EQ(plain.regions.size(), 1U);
    const ContactRegion& before = plain.regions[0];
    const ContactRegion& after = there.regions[0];
    EXPECT_NEAR((turned(before.position) - after.position).norm(), 0, 1e-9);
    EXPECT_NEAR((turned.rotation * before.normal - after.normal).norm(), 0, 1e-9);
    EXPECT_NEAR(before.length, after.length, 1e-9);
    EXPECT_NEAR(before.depth, after.depth, 0.01 * before.depth);
}

} // namespace
} // namespace proxima::contact_regions_test
