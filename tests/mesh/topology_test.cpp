#include "proxima/topology.h"

#include "code_of.h"
#include "mesh/edge_numbers.h"
#include "mesh/random_soups.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace proxima::topology_test {
namespace {

struct OracleEdge {
    EdgeVertices vertices;
    std::vector<TriangleId> triangles;
};

struct Oracle {
    std::vector<OracleEdge> edges;
    std::vector<std::array<EdgeId, 3>> triangle_edges;
};

// Looks through all edges so far for every side of every triangle.
Oracle slow_topology(const TriangleMesh& mesh)
{
    Oracle oracle;
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        const TriangleCorners& corners = mesh.triangles()[id];
        std::array<EdgeId, 3>& sides = oracle.triangle_edges.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const VertexId a{corners[k]};
            const VertexId b{corners[(k + 1) % 3]};
            sides[k] = no_edge;
            if (a == b) continue;
            const EdgeVertices vertices = {std::min(a, b), std::max(a, b)};
            auto edge =
                std::find_if(oracle.edges.begin(), oracle.edges.end(),
                             [&](const OracleEdge& each) { return each.vertices == vertices; });
            if (edge == oracle.edges.end()) {
                oracle.edges.push_back({vertices, {}});
                edge = oracle.edges.end() - 1;
            }
            sides[k] = EdgeId{static_cast<std::uint32_t>(edge - oracle.edges.begin())};
            if (edge->triangles.empty() || edge->triangles.back() != TriangleId{id}) {
                edge->triangles.push_back(TriangleId{id});
            }
        }
    }
    return oracle;
}

template <class Id>
std::vector<Id> to_vector(std::span<const Id> items)
{
    return {items.begin(), items.end()};
}

void expect_equal(const TriangleMesh& mesh, const Topology& topology, const Oracle& oracle)
{
    ASSERT_EQ(topology.vertex_count(), mesh.vertex_count());
    ASSERT_EQ(topology.triangle_count(), mesh.triangle_count());
    ASSERT_EQ(topology.edge_count(), oracle.edges.size());
    for (std::uint32_t id = 0; id < oracle.edges.size(); ++id) {
        const OracleEdge& edge = oracle.edges[id];
        EXPECT_EQ(topology.vertices(EdgeId{id}), edge.vertices);
        EXPECT_EQ(to_vector(topology.triangles(EdgeId{id})), edge.triangles);
        EXPECT_EQ(topology.find_edge(edge.vertices[1], edge.vertices[0]), EdgeId{id});
        EXPECT_EQ(topology.other_end(EdgeId{id}, edge.vertices[0]), edge.vertices[1]);
        EXPECT_EQ(topology.other_end(EdgeId{id}, edge.vertices[1]), edge.vertices[0]);
    }
    for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
        EXPECT_EQ(topology.edges(TriangleId{id}), oracle.triangle_edges[id]);
        for (std::size_t k = 0; k < 3; ++k) {
            TriangleId expected = no_triangle;
            if (const EdgeId edge = oracle.triangle_edges[id][k]; edge != no_edge) {
                const auto& both = oracle.edges[to_index(edge)].triangles;
                if (both.size() == 2) expected = both[0] == TriangleId{id} ? both[1] : both[0];
            }
            EXPECT_EQ(topology.across(TriangleId{id}, static_cast<int>(k)), expected);
        }
    }
    for (std::uint32_t vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
        std::vector<TriangleId> star;
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const TriangleCorners& corners = mesh.triangles()[id];
            if (std::count(corners.begin(), corners.end(), vertex) > 0) {
                star.push_back(TriangleId{id});
            }
        }
        std::vector<EdgeId> edges;
        for (std::uint32_t id = 0; id < oracle.edges.size(); ++id) {
            const auto [low, high] = oracle.edges[id].vertices;
            if (to_index(low) == vertex || to_index(high) == vertex) edges.push_back(EdgeId{id});
        }
        EXPECT_EQ(to_vector(topology.triangles(VertexId{vertex})), star);
        EXPECT_EQ(to_vector(topology.edges(VertexId{vertex})), edges);
    }
}

TEST(Topology, AgreesWithBruteForceOnRandomSoups)
{
    for (std::uint32_t seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = random_soup(seed);
        const auto topology =
            build_topology(mesh, {.execution = {.threads = {static_cast<int>(1 + seed % 2)}}});
        ASSERT_TRUE(topology);
        expect_equal(mesh, *topology, slow_topology(mesh));
    }
}

// Stars too long for a linear search, in a shuffled order of triangles.
TEST(Topology, AgreesWithBruteForceOnLongStars)
{
    const TriangleMesh sphere = make_sphere(3, 97);
    std::vector<TriangleCorners> triangles(sphere.triangles().begin(), sphere.triangles().end());
    std::shuffle(triangles.begin(), triangles.end(), std::mt19937(1));
    const auto mesh = make_triangle_mesh({sphere.positions().begin(), sphere.positions().end()},
                                         std::move(triangles));
    const auto topology = build_topology(*mesh);
    ASSERT_TRUE(topology);
    expect_equal(*mesh, *topology, slow_topology(*mesh));
}

TEST(Topology, NumbersEdgesByFirstAppearance)
{
    const TriangleMesh cube = make_cube(); // triangles (0, 2, 3), (0, 3, 1), ...
    const auto topology = build_topology(cube);
    ASSERT_TRUE(topology);
    EXPECT_EQ(topology->edge_count(), 18U);
    EXPECT_EQ(topology->vertices(EdgeId{0}), (EdgeVertices{VertexId{0}, VertexId{2}}));
    EXPECT_EQ(topology->vertices(EdgeId{1}), (EdgeVertices{VertexId{2}, VertexId{3}}));
    EXPECT_EQ(topology->vertices(EdgeId{2}), (EdgeVertices{VertexId{0}, VertexId{3}}));
    EXPECT_EQ(topology->vertices(EdgeId{3}), (EdgeVertices{VertexId{1}, VertexId{3}}));
    EXPECT_EQ(topology->across(TriangleId{0}, 2), TriangleId{1});
    EXPECT_EQ(topology->find_edge(VertexId{0}, VertexId{7}), no_edge);
    EXPECT_EQ(topology->find_edge(VertexId{4}, VertexId{4}), no_edge);
}

TEST(Topology, KeepsDegenerateTrianglesAsSegmentsAndPoints)
{
    const auto mesh =
        make_triangle_mesh(std::vector<Vec3>(3, Vec3::Zero()), {{0, 0, 1}, {2, 2, 2}, {1, 0, 1}});
    const auto topology = build_topology(*mesh);
    ASSERT_TRUE(topology);
    ASSERT_EQ(topology->edge_count(), 1U);
    EXPECT_EQ(topology->edges(TriangleId{0}), (std::array{no_edge, EdgeId{0}, EdgeId{0}}));
    EXPECT_EQ(topology->edges(TriangleId{1}), (std::array{no_edge, no_edge, no_edge}));
    EXPECT_EQ(to_vector(topology->triangles(EdgeId{0})),
              (std::vector{TriangleId{0}, TriangleId{2}}));
    EXPECT_EQ(to_vector(topology->triangles(VertexId{2})), (std::vector{TriangleId{1}}));
    EXPECT_EQ(topology->across(TriangleId{0}, 1), TriangleId{2});
    EXPECT_EQ(topology->across(TriangleId{0}, 0), no_triangle);
}

TEST(Topology, IsTheSameForAnyNumberOfThreads)
{
    const auto mesh = make_spaceship(60000);
    const auto one = build_topology(*mesh, {.execution = {.threads = {1}}});
    const auto three = build_topology(*mesh, {.execution = {.threads = {3}}});
    ASSERT_EQ(one->edge_count(), three->edge_count());
    for (std::uint32_t id = 0; id < one->edge_count(); ++id) {
        ASSERT_EQ(one->vertices(EdgeId{id}), three->vertices(EdgeId{id}));
        ASSERT_EQ(to_vector(one->triangles(EdgeId{id})), to_vector(three->triangles(EdgeId{id})));
    }
    for (std::uint32_t id = 0; id < one->triangle_count(); ++id) {
        ASSERT_EQ(one->edges(TriangleId{id}), three->edges(TriangleId{id}));
    }
}

TEST(Topology, AcceptsAnEmptyMesh)
{
    const auto topology = build_topology(TriangleMesh());
    ASSERT_TRUE(topology);
    EXPECT_EQ(topology->edge_count(), 0U);
    EXPECT_EQ(topology->triangle_count(), 0U);
}

TEST(Topology, RefusesMeshesBeyondTheBudget)
{
    const TriangleMesh mesh = make_sphere(20, 20);
    const auto whole = build_topology(mesh);
    const auto refused = build_topology(mesh, {.execution = {.budget = {whole->bytes() - 1}}});
    ASSERT_FALSE(refused);
    EXPECT_EQ(code_of(refused), ErrorCode::budget_exceeded);
    const auto scratch =
        mesh.triangle_count() * (edge_number_bytes - sizeof(std::array<EdgeId, 3>));
    EXPECT_TRUE(build_topology(mesh, {.execution = {.budget = {whole->bytes() + scratch}}}));
}

TEST(Topology, StopsOnRequest)
{
    Progress progress;
    progress.cancel();
    const auto stopped = build_topology(make_cube(), {.execution = {.progress = &progress}});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(code_of(stopped), ErrorCode::cancelled);
    EXPECT_STREQ(progress.stage(), "numbering edges");
}

} // namespace
} // namespace proxima::topology_test
