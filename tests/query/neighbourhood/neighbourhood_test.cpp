#include "proxima/neighbourhood.h"

#include "counted_allocations.h"
#include "geometry/closest_point.h"
#include "geometry/triangle_box.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"
#include "query/closest/brute_force.h"
#include "query/neighbourhood/random_balls.h"

#include <gtest/gtest.h>
#include <random>
#include <set>

namespace proxima::neighbourhood_test {
namespace {

using namespace testing;

using Ids = std::set<std::uint32_t>;

/// The vertex ids that a feature's triangles all have.
Ids vertices_of(const TriangleMesh& mesh, const Topology& topology, const Feature& feature)
{
    if (feature.kind == FeatureKind::vertex) return {feature.id};
    if (feature.kind == FeatureKind::edge) {
        const auto [low, high] = topology.vertices(EdgeId{feature.id});
        return {to_index(low), to_index(high)};
    }
    const TriangleCorners& corners = mesh.triangles()[feature.id];
    return {corners.begin(), corners.end()};
}

/// Breadth first over sets, by looking at every triangle for every ring.
std::vector<Ids> rings_by_sets(const TriangleMesh& mesh, const Topology& topology,
                               const Feature& feature, int rings)
{
    const auto has = [&](std::uint32_t triangle, std::uint32_t vertex) {
        return std::ranges::find(mesh.triangles()[triangle], vertex) !=
               mesh.triangles()[triangle].end();
    };
    std::vector<Ids> result(1);
    Ids seen;
    const Ids vertices = vertices_of(mesh, topology, feature);
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const bool incident =
            feature.kind == FeatureKind::face
                ? i == feature.id
                : std::ranges::all_of(vertices, [&](std::uint32_t v) { return has(i, v); });
        if (incident) result[0].insert(i);
    }
    seen = result[0];
    for (int ring = 1; ring <= rings; ++ring) {
        Ids next;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            if (seen.contains(i)) continue;
            for (const std::uint32_t near : result.back()) {
                const auto& corners = mesh.triangles()[near];
                if (std::ranges::any_of(corners, [&](std::uint32_t v) { return has(i, v); })) {
                    next.insert(i);
                }
            }
        }
        seen.insert(next.begin(), next.end());
        result.push_back(next);
    }
    return result;
}

std::vector<Feature> some_features(const TriangleMesh& mesh, const Topology& topology,
                                   std::mt19937& random, int count)
{
    std::vector<Feature> features;
    for (int i = 0; i < count; ++i) {
        const auto below = [&](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
        features.push_back({FeatureKind::vertex, below(mesh.vertex_count())});
        features.push_back({FeatureKind::face, below(mesh.triangle_count())});
        if (topology.edge_count() > 0) {
            features.push_back({FeatureKind::edge, below(topology.edge_count())});
        }
    }
    return features;
}

TEST(Rings, AgreeWithABreadthFirstSearch)
{
    std::mt19937 random(1);
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const TriangleMesh& mesh = named.mesh;
        const Topology topology = build_topology(mesh).value();
        NeighbourhoodScratch scratch(mesh);
        const int features = mesh.triangle_count() > 500 ? 2 : 8;
        for (const Feature& feature : some_features(mesh, topology, random, features)) {
            constexpr int rings = 3;
            const std::vector<Ids> truth = rings_by_sets(mesh, topology, feature, rings);
            std::vector<TriangleId> buffer(mesh.triangle_count());
            std::array<std::size_t, rings + 1> ends{};
            const Neighbourhood found =
                collect_rings(mesh, topology, feature, rings, scratch, buffer, ends);
            EXPECT_TRUE(found.complete);
            EXPECT_EQ(found.written, ends.back());
            std::size_t begin = 0;
            for (std::size_t ring = 0; ring < truth.size(); ++ring) {
                std::vector<std::uint32_t> ids;
                for (; begin < ends[ring]; ++begin) ids.push_back(to_index(buffer[begin]));
                EXPECT_TRUE(std::ranges::equal(ids, truth[ring]))
                    << "ring " << ring << " of feature " << static_cast<int>(feature.kind) << ' '
                    << feature.id;
            }
        }
    }
}

TEST(Rings, ReportABufferThatIsTooSmall)
{
    const TriangleMesh mesh = sample_mesh("icosphere:2").value();
    const Topology topology = build_topology(mesh).value();
    NeighbourhoodScratch scratch(mesh);
    const Feature feature{FeatureKind::face, 17};
    std::vector<TriangleId> all(mesh.triangle_count());
    std::array<std::size_t, 3> ends{};
    const Neighbourhood whole = collect_rings(mesh, topology, feature, 2, scratch, all, ends);
    ASSERT_TRUE(whole.complete);
    for (std::size_t capacity = 0; capacity <= whole.written + 1; ++capacity) {
        SCOPED_TRACE(capacity);
        std::vector<TriangleId> buffer(capacity, no_triangle);
        std::array<std::size_t, 3> some_ends{};
        const Neighbourhood found =
            collect_rings(mesh, topology, feature, 2, scratch, buffer, some_ends);
        EXPECT_EQ(found.complete, capacity >= whole.written);
        EXPECT_EQ(found.written, std::min(capacity, whole.written));
        std::size_t begin = 0;
        for (std::size_t ring = 0; ring < ends.size(); ++ring) {
            EXPECT_EQ(some_ends[ring], std::min(capacity, ends[ring]));
            const auto written = std::span(buffer).subspan(begin, some_ends[ring] - begin);
            const auto truth = std::span(all).subspan(begin, ends[ring] - begin);
            EXPECT_TRUE(std::ranges::is_sorted(written));
            EXPECT_TRUE(std::ranges::includes(truth, written));
            if (some_ends[ring] < ends[ring]) break;
            begin = ends[ring];
        }
    }
}

TEST(Rings, EndAtTheLastRing)
{
    const TriangleMesh mesh = cube_mesh(Vec3::Zero(), 1.0);
    const Topology topology = build_topology(mesh).value();
    NeighbourhoodScratch scratch(mesh);
    std::array<TriangleId, 12> buffer{};
    std::array<std::size_t, 9> ends{};
    const Feature corner{FeatureKind::vertex, 0};
    const Neighbourhood found = collect_rings(
        mesh, topology, corner, std::numeric_limits<int>::max(), scratch, buffer, ends);
    EXPECT_TRUE(found.complete);
    EXPECT_EQ(found.written, 12U);
    EXPECT_EQ(ends.back(), 12U);
    EXPECT_EQ(ends.front(), topology.triangles(VertexId{0}).size());
    ends.fill(99);
    EXPECT_EQ(collect_rings(mesh, topology, corner, 5, scratch, buffer, ends).written, 12U);
    EXPECT_EQ(ends[5], 12U);
    EXPECT_EQ(ends[6], 99U);
}

TEST(Rings, NeedNoClearingEvenWhenTheRoundCounterOverflows)
{
    const TriangleMesh mesh = sample_mesh("torus:12x8").value();
    const Topology topology = build_topology(mesh).value();
    NeighbourhoodScratch scratch(mesh);
    const auto rings = [&](std::uint32_t vertex) {
        std::vector<TriangleId> buffer(mesh.triangle_count());
        buffer.resize(
            collect_rings(mesh, topology, {FeatureKind::vertex, vertex}, 1, scratch, buffer)
                .written);
        return buffer;
    };
    std::vector<std::vector<TriangleId>> truth;
    for (std::uint32_t vertex = 0; vertex < 20; ++vertex) truth.push_back(rings(vertex));
    scratch.set_round(0xFFFFFFFFU - 10);
    for (std::uint32_t vertex = 0; vertex < 20; ++vertex) EXPECT_EQ(rings(vertex), truth[vertex]);
}

TEST(MetricPatch, HasAllTrianglesWithinTheRadius)
{
    std::vector<TriangleId> buffer;
    for_balls(40, 2, [&](const auto& mesh, const auto&, const auto& index, const Ball& ball) {
        buffer.resize(mesh.triangle_count());
        const Neighbourhood found = collect_triangles(index, ball.p, ball.radius, buffer);
        EXPECT_TRUE(found.complete);
        const auto ids = std::span(buffer).first(found.written);
        EXPECT_TRUE(std::ranges::is_sorted(ids));
        EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end());
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            const Vec3 closest = closest_point(mesh.triangle(TriangleId{i}), ball.p).point;
            const double distance = (closest - ball.p).norm();
            if (std::abs(distance - ball.radius) <= ball.rounding) continue;
            EXPECT_EQ(std::ranges::binary_search(ids, TriangleId{i}), distance < ball.radius)
                << "triangle " << i;
        }
    });
}

TEST(MetricPatch, AcceptsZeroAndInfiniteRadii)
{
    const TriangleMesh mesh = cube_mesh(Vec3::Zero(), 1.0);
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = build_mesh_index(mesh).value();
    std::array<TriangleId, 12> buffer{};
    const auto count = [&](const Vec3& p, double radius) {
        return collect_triangles(index, p, radius, buffer).written;
    };
    EXPECT_EQ(count(Vec3(1, 0.5, 0.25), 0.0), 1U);
    EXPECT_EQ(count(Vec3(1, 1, 1), 0.0), topology.triangles(VertexId{7}).size());
    EXPECT_EQ(count(Vec3::Zero(), 0.999), 0U);
    EXPECT_EQ(count(Vec3::Zero(), 1.0), 12U);
    EXPECT_EQ(count(Vec3(1e300, 0, 0), std::numeric_limits<double>::infinity()), 12U);
}

TEST(MetricPatch, IsVisitedWithDistancesUntilTheVisitorStops)
{
    std::vector<TriangleId> buffer;
    for_balls(20, 6, [&](const auto& mesh, const auto&, const auto& index, const Ball& ball) {
        buffer.resize(mesh.triangle_count());
        const Neighbourhood all = collect_triangles(index, ball.p, ball.radius, buffer);
        std::vector<TriangleId> visited;
        visit_triangles(index, ball.p, ball.radius, [&](TriangleId id, double squared) {
            const Vec3 closest = closest_point(mesh.triangle(id), ball.p).point;
            EXPECT_NEAR(std::sqrt(squared), (closest - ball.p).norm(), ball.rounding);
            visited.push_back(id);
            return Flow::proceed;
        });
        std::ranges::sort(visited);
        EXPECT_TRUE(std::ranges::equal(visited, std::span(buffer).first(all.written)));
        std::size_t calls = 0;
        visit_triangles(index, ball.p, ball.radius, [&](TriangleId, double) {
            return ++calls == 2 ? Flow::stop : Flow::proceed;
        });
        EXPECT_EQ(calls, std::min<std::size_t>(2, all.written));
    });
}

TEST(TrianglesInABox, AreThoseOfTheExactTest)
{
    std::mt19937 random(7);
    std::size_t some = 0;
    for_balls(30, 7, [&](const auto& mesh, const auto&, const auto& index, const Ball& ball) {
        const double half = ball.radius;
        Box box{ball.p - Vec3::Constant(half), ball.p + Vec3::Constant(half)};
        if (random() % 3 == 0) { // its planes through vertices
            const auto vertex = [&] {
                return mesh.positions()[random() % mesh.positions().size()];
            };
            const Vec3 a = vertex();
            const Vec3 b = vertex();
            box = {a.cwiseMin(b), a.cwiseMax(b)};
        }
        std::vector<TriangleId> buffer(mesh.triangle_count());
        const Neighbourhood found = collect_triangles(index, box, buffer);
        EXPECT_TRUE(found.complete);
        std::vector<TriangleId> wanted;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            if (triangle_overlaps_box(mesh.triangle(TriangleId{i}), box))
                wanted.push_back(TriangleId{i});
        }
        EXPECT_TRUE(std::ranges::equal(wanted, std::span(buffer).first(found.written)));
        if (wanted.empty()) return;
        some += wanted.size() < mesh.triangle_count() ? 1 : 0;
        EXPECT_FALSE(
            collect_triangles(index, box, std::span(buffer).first(wanted.size() - 1)).complete);
        std::size_t calls = 0;
        visit_triangles(index, box, [&](TriangleId) {
            ++calls;
            return Flow::stop;
        });
        EXPECT_EQ(calls, 1U);
    });
    EXPECT_GT(some, 100U);
    const MeshIndex index = build_mesh_index(cube_mesh(Vec3::Zero(), 1.0)).value();
    std::array<TriangleId, 12> buffer{};
    EXPECT_EQ(collect_triangles(index, Box{}, buffer).written, 0U);
    EXPECT_EQ(collect_triangles(index, Box{Vec3::Constant(NAN), Vec3::Ones()}, buffer).written, 0U);
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const MeshIndex one =
        build_mesh_index(mesh_of({Vec3(0, 0, -1), Vec3(1, 0, 2), Vec3(0, 1, 2)}, {{0, 1, 2}}))
            .value();
    const auto slab = [&](double low, double high) {
        const Box box{Vec3(-infinite, -infinite, low), Vec3(infinite, infinite, high)};
        return collect_triangles(one, box, buffer).written;
    };
    EXPECT_EQ(slab(0, 1), 1U);
    EXPECT_EQ(slab(2, 3), 1U);
    EXPECT_EQ(slab(2.5, infinite), 0U);
    EXPECT_EQ(
        collect_triangles(index, Box{Vec3::Constant(-infinite), Vec3::Constant(infinite)}, buffer)
            .written,
        12U);
}

TEST(FeaturesWithin, AgreeWithAllVerticesEdgesAndFaces)
{
    std::vector<NearestFeature> buffer;
    for_balls(
        30, 4, [&](const auto& mesh, const auto& topology, const auto& index, const Ball& ball) {
            buffer.resize(mesh.vertex_count() + topology.edge_count() + mesh.triangle_count());
            const Neighbourhood found = collect_features(index, ball.p, ball.radius, buffer);
            EXPECT_TRUE(found.complete);
            const auto features = std::span(buffer).first(found.written);
            for (std::size_t i = 1; i < features.size(); ++i)
                EXPECT_LT(features[i - 1].feature, features[i].feature);
            const auto expect = [&](FeatureKind kind, std::uint32_t id, const Vec3& closest) {
                const double distance = (closest - ball.p).norm();
                const auto place =
                    std::ranges::find(features, Feature{kind, id}, &NearestFeature::feature);
                if (place != features.end()) {
                    EXPECT_NEAR(std::sqrt(place->squared), distance, ball.rounding);
                }
                if (std::abs(distance - ball.radius) <= ball.rounding) return;
                EXPECT_EQ(place != features.end(), distance < ball.radius)
                    << "kind " << static_cast<int>(kind) << " id " << id;
            };
            for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
                if (topology.triangles(VertexId{i}).empty()) continue;
                expect(FeatureKind::vertex, i, mesh.position(VertexId{i}));
            }
            for (std::uint32_t i = 0; i < topology.edge_count(); ++i) {
                const auto [low, high] = topology.vertices(EdgeId{i});
                const Segment edge{mesh.position(low), mesh.position(high)};
                expect(FeatureKind::edge, i, closest_point(edge, ball.p).point);
            }
            for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
                const Triangle triangle = mesh.triangle(TriangleId{i});
                expect(FeatureKind::face, i, closest_point(triangle, ball.p).point);
            }
        });
}

TEST(Neighbourhoods, ReportABufferThatIsTooSmallAndDoNotAllocate)
{
    const TriangleMesh mesh = sample_mesh("sphere:30x30").value();
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = build_mesh_index(mesh).value();
    NeighbourhoodScratch scratch(mesh);
    std::vector<TriangleId> all(mesh.triangle_count());
    std::vector<NearestFeature> all_features(4 * mesh.triangle_count());
    const Vec3 p(0.3, 0.4, 0.9);
    const std::size_t before = allocation_count();
    const Neighbourhood rings =
        collect_rings(mesh, topology, {FeatureKind::vertex, 0}, 5, scratch, all);
    const Neighbourhood triangles = collect_triangles(index, p, 0.3, all);
    const Neighbourhood features = collect_features(index, p, 0.3, all_features);
    std::array<NearTriangle, 20> nearest{};
    (void)collect_nearest(index, p, nearest);
    std::size_t visited = 0;
    visit_nearest(index, p, nearest,
                  [&](TriangleId, double) { return ++visited < 50 ? Flow::proceed : Flow::stop; });
    std::array<TriangleId, 20> in_box{};
    (void)collect_triangles(index, Box{p, p + Vec3::Ones()}, in_box);
    EXPECT_EQ(allocation_count(), before);
    EXPECT_TRUE(rings.complete && triangles.complete && features.complete);
    ASSERT_GT(triangles.written, 10U);
    for (const std::size_t capacity : {std::size_t{0}, std::size_t{1}, triangles.written - 1,
                                       triangles.written, triangles.written + 1}) {
        std::vector<TriangleId> buffer(capacity);
        const Neighbourhood found = collect_triangles(index, p, 0.3, buffer);
        EXPECT_EQ(found.complete, capacity >= triangles.written);
        EXPECT_EQ(found.written, std::min(capacity, triangles.written));
        EXPECT_TRUE(std::ranges::includes(std::span(all).first(triangles.written),
                                          std::span(buffer).first(found.written)));
    }
    for (const std::size_t capacity : {std::size_t{0}, features.written - 1, features.written}) {
        std::vector<NearestFeature> buffer(capacity);
        const Neighbourhood found = collect_features(index, p, 0.3, buffer);
        EXPECT_EQ(found.complete, capacity >= features.written);
        EXPECT_EQ(found.written, std::min(capacity, features.written));
    }
}

} // namespace
} // namespace proxima::neighbourhood_test
