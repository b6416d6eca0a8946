// The thesis's proximity octree against brute force, and against its own figures.
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include "code_of.h"
#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_box.h"
#include "index/lists/region_oracle.h"
#include "thesis/proximity_octree/convex_meshes.h"
#include "thesis/proximity_octree/list_statistics.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <limits>

namespace proxima::thesis_proximity_octree_test {
namespace {

using test::convex_meshes;
using test::NamedMesh;

constexpr std::array kinds = {FeatureKind::vertex, FeatureKind::edge, FeatureKind::face};

const std::vector<NamedMesh>& meshes()
{
    static const std::vector<NamedMesh> all = convex_meshes();
    return all;
}

ThesisProximityOctree built(const TriangleMesh& mesh, const Topology& topology,
                            const ThesisProximityOptions& options = {})
{
    auto octree = build_thesis_proximity_octree(mesh, topology, options);
    if (!octree) throw std::runtime_error(describe(octree.error()));
    return *octree;
}

bool lists(const ThesisProximityOctree& octree, const ThesisCell& cell, Feature feature)
{
    const auto list = octree.closest(cell, feature.kind);
    return std::ranges::find(list, feature.id) != list.end();
}

/// The point of a box with these parts of its edges.
Vec3 point_in(const Box& box, const Vec3& parts)
{
    return box.lower + parts.cwiseProduct(box.upper - box.lower);
}

/// The squared distance of a feature, its borders included.
double squared_distance(const TriangleMesh& mesh, const Topology& topology, Feature feature,
                        const Vec3& p)
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        return (mesh.position(VertexId{feature.id}) - p).squaredNorm();
    case FeatureKind::edge: {
        const auto [a, b] = topology.vertices(EdgeId{feature.id});
        return (closest_point(Segment{mesh.position(a), mesh.position(b)}, p).point - p)
            .squaredNorm();
    }
    case FeatureKind::face:
        break;
    }
    return (closest_point(mesh.triangle(TriangleId{feature.id}), p).point - p).squaredNorm();
}

double brute_distance(const TriangleMesh& mesh, const Topology& topology, const Vec3& p)
{
    double best = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t)
        best = std::min(best, squared_distance(mesh, topology, {FeatureKind::face, t}, p));
    return std::sqrt(best);
}

bool is_inside(const TriangleMesh& mesh, const Vec3& p)
{
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const Triangle triangle = mesh.triangle(TriangleId{t});
        if (orient3d(triangle[0], triangle[1], triangle[2], p) >= 0) return false;
    }
    return true;
}

std::vector<Feature> all_features(const Topology& topology)
{
    std::vector<Feature> features;
    for (std::uint32_t v = 0; v < topology.vertex_count(); ++v)
        if (!topology.triangles(VertexId{v}).empty()) features.push_back({FeatureKind::vertex, v});
    for (std::uint32_t e = 0; e < topology.edge_count(); ++e)
        features.push_back({FeatureKind::edge, e});
    for (std::uint32_t t = 0; t < topology.triangle_count(); ++t)
        features.push_back({FeatureKind::face, t});
    return features;
}

/// Whether the faces of an edge are one plane, by angles in 113-bit numbers.
bool is_flat(const TriangleMesh& mesh, const Topology& topology, EdgeId edge)
{
    const auto sides = topology.triangles(edge);
    const auto one = oracle::quad_normal(mesh.triangle(sides[0]));
    const auto other = oracle::quad_normal(mesh.triangle(sides[1]));
    const auto turn = oracle::cross(one, other);
    const auto lengths = dot(one, one) * dot(other, other);
    return dot(turn, turn) <= oracle::Quad(1e-16) * lengths;
}

double diagonal_of(const TriangleMesh& mesh)
{
    return bounding_box(mesh).extent().norm();
}

TEST(ThesisLabels, EveryPointOutsideHasItsClosestFeatureInItsLeaf)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> part(0, 1);
    for (const NamedMesh& named : meshes()) {
        const TriangleMesh& mesh = named.mesh;
        SCOPED_TRACE(named.name);
        const Topology topology = *build_topology(mesh);
        const auto octree =
            built(mesh, topology, {.max_depth = mesh.triangle_count() > 200 ? 3 : 4});
        const double tolerance = 1e-12 * (diagonal_of(mesh) + mesh.positions()[0].norm());
        std::size_t points = 0;
        octree.for_each_leaf([&](const ThesisCell& cell) {
            const Box box = octree.box(cell);
            for (int i = 0; i < 12; ++i) {
                // The corners first, then anywhere.
                const Vec3 p = i < 8 ? oracle::box_corner(box, i)
                                     : point_in(box, {part(random), part(random), part(random)});
                if (is_inside(mesh, p)) {
                    ASSERT_NE(octree.type(cell), CellClass::outer);
                    continue;
                }
                ++points;
                double listed = std::numeric_limits<double>::infinity();
                for (const FeatureKind kind : kinds) {
                    for (const std::uint32_t id : octree.closest(cell, kind)) {
                        const double squared = squared_distance(mesh, topology, {kind, id}, p);
                        listed = std::min(listed, squared);
                    }
                }
                const double closest = brute_distance(mesh, topology, p);
                if (octree.type(cell) == CellClass::inner) {
                    // Only where it touches the surface from behind.
                    ASSERT_LE(closest, tolerance) << p.transpose();
                } else {
                    ASSERT_LE(std::sqrt(listed), closest + tolerance) << p.transpose();
                }
            }
        });
        EXPECT_GT(points, 500U);
    }
}

TEST(ThesisLabels, ListsHoldExactlyTheRegionsThatMeetTheCell)
{
    std::mt19937 random(8);
    std::uint64_t listed_pairs = 0;
    std::uint64_t other_pairs = 0;
    for (const NamedMesh& named : meshes()) {
        const TriangleMesh& mesh = named.mesh;
        SCOPED_TRACE(named.name);
        const Topology topology = *build_topology(mesh);
        const auto octree = built(mesh, topology, {.max_depth = 4});
        const auto features = all_features(topology);
        // What rounding may do on top of the closed sets; thin shapes amplify it.
        const double slack = 1e-9 * octree.frame().edge.x();
        std::vector<ThesisCell> cells;
        octree.for_each_leaf([&](const ThesisCell& cell) {
            if (octree.type(cell) != CellClass::inner) cells.push_back(cell);
        });
        const auto check = [&](const ThesisCell& cell, Feature feature) {
            if (feature.kind == FeatureKind::edge && is_flat(mesh, topology, EdgeId{feature.id})) {
                EXPECT_FALSE(lists(octree, cell, feature));
                return;
            }
            const auto planes = oracle::region_planes(mesh, topology, feature);
            if (lists(octree, cell, feature)) {
                ++listed_pairs;
                EXPECT_TRUE(oracle::meets_box(planes, octree.box(cell), slack))
                    << "kind " << static_cast<int>(feature.kind) << " id " << feature.id;
            } else {
                ++other_pairs;
                EXPECT_FALSE(oracle::meets_box(planes, octree.box(cell), 0))
                    << "kind " << static_cast<int>(feature.kind) << " id " << feature.id;
            }
        };
        std::uniform_int_distribution<std::size_t> any_cell(0, cells.size() - 1);
        std::uniform_int_distribution<std::size_t> any_feature(0, features.size() - 1);
        for (int i = 0; i < 60; ++i) {
            const ThesisCell& cell = cells[any_cell(random)];
            check(cell, features[any_feature(random)]);
            for (const FeatureKind kind : kinds) {
                const auto list = octree.closest(cell, kind);
                if (list.empty()) continue;
                check(
                    cell,
                    {kind,
                     list[std::uniform_int_distribution<std::size_t>(0, list.size() - 1)(random)]});
                // One that is near, and listed in a neighbour if not here.
                const auto near = octree.closest(cells[any_cell(random)], kind);
                if (!near.empty()) check(cell, {kind, near[0]});
            }
        }
    }
    EXPECT_GT(listed_pairs, 2000U);
    EXPECT_GT(other_pairs, 1500U);
}

TEST(ThesisLabels, BoundaryCellsListTheFeaturesThatTouchThem)
{
    for (const NamedMesh& named : meshes()) {
        const TriangleMesh& mesh = named.mesh;
        if (mesh.triangle_count() > 400) continue;
        SCOPED_TRACE(named.name);
        const Topology topology = *build_topology(mesh);
        const auto octree = built(mesh, topology, {.max_depth = 3});
        octree.for_each_leaf([&](const ThesisCell& cell) {
            const Box box = octree.box(cell);
            bool touched = false;
            for (const Feature feature : all_features(topology)) {
                bool touches = false;
                if (feature.kind == FeatureKind::vertex) {
                    touches = box.contains(mesh.position(VertexId{feature.id}));
                } else if (feature.kind == FeatureKind::edge) {
                    if (is_flat(mesh, topology, EdgeId{feature.id})) continue;
                    const auto [a, b] = topology.vertices(EdgeId{feature.id});
                    // The triangle's test by separating axes holds for a triangle that is a
                    // segment.
                    touches = triangle_overlaps_box(
                        {{mesh.position(b), mesh.position(a), mesh.position(a)}}, box);
                } else {
                    touches = triangle_overlaps_box(mesh.triangle(TriangleId{feature.id}), box);
                }
                touched = touched || touches;
                const auto list = octree.touching(cell, feature.kind);
                ASSERT_EQ(std::ranges::find(list, feature.id) != list.end(), touches);
            }
            ASSERT_EQ(octree.type(cell) == CellClass::boundary, touched);
            if (!touched) {
                ASSERT_EQ(octree.type(cell) == CellClass::inner, is_inside(mesh, box.center()));
            }
        });
    }
}

TEST(ThesisLabels, LeavesAreWithinTheThresholdsOrAtTheDeepestLevel)
{
    const TriangleMesh mesh = make_sphere(12, 16);
    const Topology topology = *build_topology(mesh);
    for (const KindThresholds thresholds :
         {KindThresholds{4, 5, 6}, KindThresholds{0, 0, 0}, KindThresholds{1000, 1000, 6},
          KindThresholds{1000, 6, 1000}, KindThresholds{3, 1000, 1000}}) {
        const auto octree = built(mesh, topology, {.max_depth = 4, .thresholds = thresholds});
        std::size_t shallow = 0;
        std::size_t deep = 0;
        octree.for_each_leaf([&](const ThesisCell& cell) {
            if (octree.type(cell) == CellClass::inner) return;
            if (depth(cell.key) == 4) {
                ++deep;
                return;
            }
            ++shallow;
            for (const FeatureKind kind : kinds) {
                const auto list = octree.type(cell) == CellClass::outer
                                      ? octree.closest(cell, kind)
                                      : octree.touching(cell, kind);
                EXPECT_LE(list.size(), thresholds.of(kind));
            }
        });
        EXPECT_GT(deep, 0U);
        EXPECT_EQ(shallow == 0, thresholds == (KindThresholds{0, 0, 0})) << shallow;
    }
}

// Thesis 5.1.2; the figures of cells outside the circumscribed sphere were found before by linear
// programs on the regions' half-spaces.
TEST(ThesisLabels, ReproduceTheMeanListsOfFigure53)
{
    const TriangleMesh mesh = make_sphere(50, 50);
    const Topology topology = *build_topology(mesh);
    const MeshSphere sphere = circumscribed_sphere(mesh);
    struct Expected {
        int depth;
        double mean;
        double percent_up_to_16;
    };
    for (const Expected& expected : {Expected{3, 97.72, 0}, {4, 32.66, 1.6}, {5, 12.15, 84}}) {
        const auto octree =
            built(mesh, topology, {.max_depth = expected.depth, .thresholds = {0, 0, 0}});
        const auto lengths = outer_list_lengths(octree, sphere);
        const ListStatistics statistics = list_statistics(lengths);
        EXPECT_NEAR(statistics.mean, expected.mean, 0.005);
        EXPECT_NEAR(100 * statistics.share_up_to(16), expected.percent_up_to_16, 0.5);
        if (expected.depth == 4) {
            EXPECT_EQ(statistics.cells, 3176U);
        }
    }
}

TEST(ThesisLabels, TheRootIsLargerByTheMargin)
{
    const TriangleMesh mesh = make_cube();
    const Topology topology = *build_topology(mesh);
    for (const double margin : {0.0, 0.25, 0.5, 3.0}) {
        const auto octree = built(mesh, topology, {.max_depth = 2, .margin = margin});
        EXPECT_DOUBLE_EQ(octree.frame().edge.x(), 2 * (1 + margin));
        EXPECT_DOUBLE_EQ(octree.frame().lower.x(), -(1 + margin));
        EXPECT_TRUE(cell_box(octree.frame(), CellKey{}).contains(Vec3(1, 1, 1)));
    }
    for (const auto& [name, other] : meshes()) {
        for (const double margin : {0.0, 1e-17, 1e-16, 1e-3}) {
            const auto octree =
                built(other, *build_topology(other), {.max_depth = 0, .margin = margin});
            const Box root = cell_box(octree.frame(), CellKey{});
            for (const Vec3& p : other.positions()) ASSERT_TRUE(root.contains(p)) << name;
        }
    }
}

TEST(ThesisLabels, LocateFindsTheLeafThatHoldsThePoint)
{
    std::mt19937 random(9);
    std::uniform_real_distribution<double> part(-0.1, 1.1);
    const TriangleMesh mesh = make_icosphere(1);
    const Topology topology = *build_topology(mesh);
    const auto octree = built(mesh, topology, {.max_depth = 4});
    const Box root = cell_box(octree.frame(), CellKey{});
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p = point_in(root, {part(random), part(random), part(random)});
        const auto cell = octree.locate(p);
        ASSERT_EQ(cell.has_value(), root.contains(p));
        if (cell) {
            ASSERT_TRUE(octree.box(*cell).contains(p));
        }
    }
    octree.for_each_leaf([&](const ThesisCell& cell) {
        const auto found = octree.locate(octree.box(cell).lower);
        ASSERT_TRUE(found && found->key == cell.key && found->leaf == cell.leaf);
    });
    EXPECT_TRUE(octree.locate(root.upper));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(octree.locate({nan, 0, 0}));
    EXPECT_FALSE(octree.locate({0, infinity, 0}));
}

TEST(ThesisLabels, AreTheSameForAnyNumberOfThreads)
{
    const TriangleMesh mesh = make_sphere(20, 20);
    const Topology topology = *build_topology(mesh);
    const auto one = built(mesh, topology, {.max_depth = 4, .execution = {.threads = {1}}});
    const auto four = built(mesh, topology, {.max_depth = 4, .execution = {.threads = {4}}});
    EXPECT_EQ(one.node_count(), four.node_count());
    EXPECT_EQ(one.reference_count(), four.reference_count());
    std::vector<ThesisCell> cells;
    one.for_each_leaf([&](const ThesisCell& cell) { cells.push_back(cell); });
    std::size_t at = 0;
    four.for_each_leaf([&](const ThesisCell& cell) {
        ASSERT_EQ(cell.key, cells[at].key);
        ASSERT_EQ(cell.leaf, cells[at].leaf);
        for (const FeatureKind kind : kinds) {
            ASSERT_TRUE(std::ranges::equal(one.closest(cell, kind), four.closest(cell, kind)));
            ASSERT_TRUE(std::ranges::equal(one.touching(cell, kind), four.touching(cell, kind)));
        }
        ++at;
    });
}

TEST(ThesisLabels, AreInvariantToScalingAndPermutationOfAxes)
{
    const TriangleMesh mesh = make_icosphere(2);
    const Topology topology = *build_topology(mesh);
    const auto octree = built(mesh, topology, {.max_depth = 4});
    const auto scaled = built(test::mapped(mesh, [](const Vec3& p) { return Vec3(0x1p-40 * p); }),
                              topology, {.max_depth = 4});
    EXPECT_EQ(scaled.reference_count(), octree.reference_count());
    const auto turned =
        built(test::mapped(mesh, [](const Vec3& p) { return Vec3(p.y(), p.z(), p.x()); }), topology,
              {.max_depth = 4});
    EXPECT_EQ(turned.reference_count(), octree.reference_count());
    EXPECT_EQ(turned.node_count(), octree.node_count());
}

TEST(ThesisLabels, RefuseInvalidOptions)
{
    const TriangleMesh mesh = make_cube();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const ThesisProximityOptions& options :
         {ThesisProximityOptions{.max_depth = -1}, ThesisProximityOptions{.max_depth = 20},
          ThesisProximityOptions{.margin = -0.1}, ThesisProximityOptions{.margin = nan},
          ThesisProximityOptions{.margin = 1e7}, ThesisProximityOptions{.convexity_tolerance = nan},
          ThesisProximityOptions{.flat_sine = -1}}) {
        const auto octree = build_thesis_proximity_octree(mesh, options);
        ASSERT_FALSE(octree);
        EXPECT_EQ(code_of(octree), ErrorCode::invalid_argument);
    }
    const auto small = build_thesis_proximity_octree(
        make_sphere(20, 20),
        {.max_depth = 9, .thresholds = {0, 0, 0}, .execution = {.budget = {20'000'000}}});
    ASSERT_FALSE(small);
    EXPECT_EQ(code_of(small), ErrorCode::budget_exceeded);
}

TEST(ThesisLabels, CanBeStoppedAtAnyReport)
{
    const TriangleMesh mesh = make_sphere(8, 8);
    for (std::uint64_t reports = 1;; ++reports) {
        Progress progress;
        progress.cancel_after(reports);
        const auto octree = build_thesis_proximity_octree(
            mesh, {.max_depth = 3, .execution = {.threads = {1}, .progress = &progress}});
        if (!progress.cancelled()) {
            EXPECT_TRUE(octree);
            EXPECT_GT(reports, 20U);
            break;
        }
        ASSERT_FALSE(octree) << "not stopped at report " << reports;
        ASSERT_EQ(code_of(octree), ErrorCode::cancelled);
    }
}

} // namespace
} // namespace proxima::thesis_proximity_octree_test
