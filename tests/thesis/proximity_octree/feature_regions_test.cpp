// Voronoi regions of features: who is in them, and how they are drawn.
#include "thesis/proximity_octree/feature_regions.h"

#include "code_of.h"
#include "index/lists/region_oracle.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/mesh_report.h"
#include "thesis/proximity_octree/convex_meshes.h"
#include "thesis/proximity_octree/unbounded_sum.h"

#include <gtest/gtest.h>
#include <limits>

namespace proxima::feature_regions_test {
namespace {

constexpr std::array kinds = {FeatureKind::vertex, FeatureKind::edge, FeatureKind::face};

std::uint32_t count_of(const Topology& topology, FeatureKind kind)
{
    const std::size_t count = kind == FeatureKind::vertex ? topology.vertex_count()
                              : kind == FeatureKind::edge ? topology.edge_count()
                                                          : topology.triangle_count();
    return static_cast<std::uint32_t>(count);
}

/// How far the point is outside the polyhedron's planes, at most 0 inside.
double beyond(const ConvexPolyhedron& region, const Vec3& p)
{
    double worst = -std::numeric_limits<double>::infinity();
    for (std::uint32_t f = 0; f < region.facet_count(); ++f) {
        const HalfSpace plane = region.half_space(f);
        worst = std::max(worst, plane.normal.dot(p) - plane.offset);
    }
    return worst;
}

TEST(FeatureRegions, ContainThePointsThatTheThesisDefines)
{
    std::mt19937 random(21);
    std::normal_distribution<double> normal;
    for (const auto& [name, mesh] : test::convex_meshes()) {
        if (name == "plate" || name == "needle") continue; // their planes are too far from round
        SCOPED_TRACE(name);
        const Topology topology = *build_topology(mesh);
        const Box bounds = bounding_box(mesh);
        const double size = bounds.extent().norm();
        const double tolerance = 1e-9 * (size + bounds.center().norm());
        for (const FeatureKind kind : kinds) {
            for (int i = 0; i < 12; ++i) {
                const Feature feature{kind, std::uniform_int_distribution<std::uint32_t>(
                                                0, count_of(topology, kind) - 1)(random)};
                const auto region = voronoi_region_of(mesh, topology, feature);
                ASSERT_TRUE(region) << describe(region.error());
                EXPECT_FALSE(region->is_bounded());
                if (region->dimension() < 3) continue;
                const auto planes = oracle::region_planes(mesh, topology, feature);
                for (int k = 0; k < 40; ++k) {
                    const Vec3 away{normal(random), normal(random), normal(random)};
                    const Vec3 p = bounds.center() + 0.5 * size * away;
                    double worst = -std::numeric_limits<double>::infinity();
                    for (const oracle::QuadPlane& plane : planes) {
                        const auto height = dot(plane.normal, oracle::QuadPoint(p)) - plane.offset;
                        worst = std::max(worst, static_cast<double>(height));
                    }
                    const double ours = beyond(*region, p);
                    EXPECT_EQ(ours > tolerance, worst > tolerance)
                        << ours << " against " << worst << ", kind " << static_cast<int>(kind);
                }
            }
        }
    }
}

/// How far the cell's centre is outside the facets of a sum of a region and the cube of half size
/// 1, scaled to the cell; at most 0 where region and cell meet. All facets, or those named.
double beyond(const MinkowskiSum& sum, double half, const Vec3& center,
              const std::vector<std::uint32_t>* facets = nullptr)
{
    const MinkowskiSum scaled = sum.scaled(half);
    double worst = -std::numeric_limits<double>::infinity();
    const auto look = [&](std::uint32_t f) {
        const HalfSpace plane = scaled.half_space(f);
        worst = std::max(worst, plane.normal.dot(center) - plane.offset);
    };
    if (facets != nullptr) {
        for (const std::uint32_t f : *facets) look(f);
    } else {
        for (std::uint32_t f = 0; f < scaled.facet_count(); ++f) look(f);
    }
    return worst;
}

// Thesis 4.3.3: the region itself, the region with its rays cut off beyond the root, and what is
// left of the sum when the facets that the cut made are removed.
TEST(FeatureRegions, MeetTheSameCellsWhetherCutOrNot)
{
    std::mt19937 random(22);
    std::uniform_real_distribution<double> part(-1, 1);
    const ConvexPolyhedron cube =
        polyhedron_of_box({Vec3::Constant(-1), Vec3::Constant(1)}).value();
    std::size_t met = 0;
    std::size_t missed = 0;
    for (const auto& [name, mesh] : test::convex_meshes()) {
        if (name == "plate" || name == "needle") continue; // their cones open too slowly to be cut
        SCOPED_TRACE(name);
        const Topology topology = *build_topology(mesh);
        const Box bounds = bounding_box(mesh);
        const double root_half = 0.75 * bounds.extent().maxCoeff();
        const double unsure = 1e-8 * (root_half + bounds.center().norm());
        for (const FeatureKind kind : kinds) {
            for (int i = 0; i < 10; ++i) {
                const Feature feature{kind, std::uniform_int_distribution<std::uint32_t>(
                                                0, count_of(topology, kind) - 1)(random)};
                const auto region = voronoi_region_of(mesh, topology, feature);
                ASSERT_TRUE(region) << describe(region.error());
                const double length = 1e4 * root_half;
                const auto ideal = minkowski_sum(*region, cube);
                const auto cut = minkowski_sum(cut_rays(*region, length).value(), cube);
                const auto removed = sum_by_cutting(*region, cube, length);
                ASSERT_TRUE(ideal && cut && removed);
                EXPECT_FALSE(ideal->is_bounded());
                EXPECT_TRUE(cut->is_bounded());
                for (int k = 0; k < 60; ++k) {
                    const double half = std::ldexp(root_half, -static_cast<int>(random() % 7));
                    Vec3 center = bounds.center();
                    const auto cells = static_cast<int>(std::lround(root_half / half));
                    for (int axis = 0; axis < 3; ++axis)
                        center[axis] += (2 * static_cast<int>(random() % cells) + 1 - cells) * half;
                    const double truth = beyond(*ideal, half, center);
                    if (std::abs(truth) < unsure) continue;
                    ++(truth > 0 ? missed : met);
                    EXPECT_EQ(beyond(*cut, half, center) > 0, truth > 0);
                    EXPECT_EQ(beyond(removed->intermediate, half, center, &removed->remaining) > 0,
                              truth > 0);
                }
            }
        }
    }
    EXPECT_GT(met, 3000U);
    EXPECT_GT(missed, 3000U);
}

TEST(FeatureRegions, AreDrawnAtTheRequestedLength)
{
    const TriangleMesh mesh = make_octahedron();
    const Topology topology = *build_topology(mesh);
    for (const FeatureKind kind : kinds) {
        const auto closed = voronoi_region_mesh(mesh, topology, {kind, 0}, 0.5);
        ASSERT_TRUE(closed) << describe(closed.error());
        const auto report = *report_mesh(*closed);
        EXPECT_TRUE(report.closed);
        EXPECT_EQ(report.orientation, Orientation::outward);
        const auto open = voronoi_region_mesh(mesh, topology, {kind, 0}, 0.5, RegionEnd::open);
        ASSERT_TRUE(open);
        EXPECT_FALSE(report_mesh(*open)->closed);
    }
    // A prism of length 0.5 over an equilateral triangle of side sqrt(2).
    const auto prism = *voronoi_region_mesh(mesh, topology, {FeatureKind::face, 3}, 0.5);
    EXPECT_NEAR(report_mesh(prism)->signed_volume.value(), 0.5 * std::sqrt(3.0) / 2, 1e-12);
    // The pyramid of a vertex: four rays of length 0.5 along (1, +-1, +-1).
    const auto pyramid = *voronoi_region_mesh(mesh, topology, {FeatureKind::vertex, 0}, 0.5);
    const double edge = 0.5 / std::sqrt(3.0);
    EXPECT_NEAR(report_mesh(pyramid)->signed_volume.value(), 4 * edge * edge * edge / 3, 1e-12);
}

TEST(FeatureRegions, RefuseFeaturesWithoutARegion)
{
    const TriangleMesh cube = make_cube();
    const Topology topology = *build_topology(cube);
    for (const FeatureKind kind : kinds) {
        const auto none = voronoi_region_of(cube, topology, {kind, count_of(topology, kind)});
        ASSERT_FALSE(none);
        EXPECT_EQ(code_of(none), ErrorCode::invalid_argument);
    }
    for (const double length : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        for (const RegionEnd end : {RegionEnd::open, RegionEnd::closed})
            EXPECT_FALSE(voronoi_region_mesh(cube, topology, {FeatureKind::face, 0}, length, end));
    }

    const TriangleMesh torus = make_torus(12, 8);
    const Topology around = *build_topology(torus);
    std::size_t refused = 0;
    for (std::uint32_t e = 0; e < around.edge_count(); ++e) {
        const auto region = voronoi_region_of(torus, around, {FeatureKind::edge, e});
        if (region) continue;
        ++refused;
        EXPECT_EQ(code_of(region), ErrorCode::invalid_mesh);
    }
    EXPECT_GT(refused, 30U);
    EXPECT_LT(refused, around.edge_count());

    const auto open = *make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}, {2, 0, 0}},
                                          {{0, 1, 2}, {0, 1, 4}});
    const Topology few = *build_topology(open);
    EXPECT_TRUE(voronoi_region_of(open, few, {FeatureKind::face, 0}));
    for (const Feature feature : {Feature{FeatureKind::edge, 1}, Feature{FeatureKind::vertex, 2},
                                  Feature{FeatureKind::vertex, 3}, Feature{FeatureKind::face, 1}})
        EXPECT_FALSE(voronoi_region_of(open, few, feature));
}

} // namespace
} // namespace proxima::feature_regions_test
