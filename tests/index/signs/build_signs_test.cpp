// Signs as an addition to an index: what they share, keep, hold and refuse.
#include "cancellation.h"
#include "code_of.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/signs/sign_parts.h"
#include "index/test_meshes.h"
#include "mesh/surface_parts.h"
#include "proxima/mesh_index.h"
#include "proxima/signed_distance.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <vector>

namespace proxima::build_signs_test {
namespace {

using namespace testing;

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b)
{
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// Three pages of two sides each about one edge: closed, the edge has six triangles.
TriangleMesh closed_book()
{
    TriangleMesh book;
    for (int page = 0; page < 3; ++page) {
        const double angle = 2.0 * page;
        const auto at = [&](double turn, double z) {
            return Vec3(std::cos(angle + turn), std::sin(angle + turn), z);
        };
        const TriangleMesh wedge = mesh_of({Vec3(0, 0, 0), Vec3(0, 0, 1), at(0, 0.5), at(0.5, 0.5)},
                                           {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}});
        book = page == 0 ? wedge : joined(book, wedge);
    }
    std::vector<TriangleCorners> triangles(book.triangles().begin(), book.triangles().end());
    for (TriangleCorners& corners : triangles) {
        for (std::uint32_t& corner : corners)
            if (corner % 4 < 2) corner %= 4;
    }
    triangles.push_back({0, 1, 1}); // a segment: no proper triangle of the edge
    return mesh_of({book.positions().begin(), book.positions().end()}, triangles);
}

TEST(WithSigns, SharesAllArraysAndKeepsOtherAdditions)
{
    const MeshIndex plain = build_mesh_index(torus_mesh(1.0, 0.3, 12, 8)).value();
    const MeshIndex signs = with_signs(plain).value();
    EXPECT_FALSE(plain.has_signs());
    EXPECT_TRUE(signs.has_signs());
    EXPECT_EQ(bytes_of(plain).signs, 0U);
    EXPECT_EQ(signs.bytes(), plain.bytes() + bytes_of(signs).signs);
    EXPECT_EQ(signs.parts().blocks().data(), plain.parts().blocks().data());
    EXPECT_EQ(signs.parts().double_rows().data(), plain.parts().double_rows().data());

    const MeshIndex one = with_lists(with_slabs(signs).value()).value();
    EXPECT_EQ(one.parts().signs(), signs.parts().signs());
    const MeshIndex two = with_signs(with_slabs(with_lists(plain).value()).value()).value();
    for (const MeshIndex& index : {one, two})
        EXPECT_TRUE(index.has_lists() && index.has_slabs() && index.has_signs());
}

TEST(WithSigns, AreGivenUpByARefit)
{
    const TriangleMesh mesh = cube_mesh(Vec3::Zero(), 1.0);
    const MeshIndex signs = with_signs(build_mesh_index(mesh).value()).value();
    const MeshIndex moved = refit_index(signs, mesh, build_topology(mesh).value()).value();
    EXPECT_FALSE(moved.has_signs());
}

TEST(WithSigns, HaveTheSameBytesForAnyNumberOfThreads)
{
    const TriangleMesh mesh =
        joined(sample_mesh("spaceship:1300").value(), sphere_mesh(Vec3(9, 9, 9), 1.0, 20, 30));
    const MeshIndex plain = build_mesh_index(mesh).value();
    const MeshIndex one = with_signs(plain, {.execution = {.threads = {1}}}).value();
    const MeshIndex three = with_signs(plain, {.execution = {.threads = {3}}}).value();
    const SignArrays& a = one.parts().signs()->arrays();
    const SignArrays& b = three.parts().signs()->arrays();
    EXPECT_TRUE(same_bytes(a.rows, b.rows));
    EXPECT_TRUE(same_bytes(a.sides, b.sides));
    EXPECT_TRUE(same_bytes(a.vertex_sides, b.vertex_sides));
    EXPECT_TRUE(same_bytes(a.vertices, b.vertices));
    EXPECT_TRUE(same_bytes(a.edges, b.edges));
    EXPECT_TRUE(same_bytes(a.edge_lists, b.edge_lists));
    EXPECT_TRUE(same_bytes(a.winding.clusters, b.winding.clusters));
    EXPECT_TRUE(same_bytes(a.winding.order, b.winding.order));
    EXPECT_FALSE(a.sides.empty());
}

TEST(WithSigns, NameTheProperTrianglesOfEveryEdge)
{
    std::size_t lists = 0;
    for (const TriangleMesh& mesh :
         {torus_mesh(1.0, 0.3, 12, 8), closed_book(),
          joined(cube_mesh(Vec3::Zero(), 1.0), inverted(cube_mesh(Vec3::Zero(), 0.5)))}) {
        const MeshIndex index = with_signs(build_mesh_index(mesh).value()).value();
        const Topology topology = build_topology(mesh).value();
        const SignArrays& signs = index.parts().signs()->arrays();
        ASSERT_EQ(signs.edges.size(), topology.edge_count());
        for (std::uint32_t edge = 0; edge < topology.edge_count(); ++edge) {
            std::vector<TriangleId> truth;
            for (const TriangleId id : topology.triangles(EdgeId{edge})) {
                if (detail::is_proper(mesh.triangles()[to_index(id)])) truth.push_back(id);
            }
            const std::uint32_t word = signs.edges[edge];
            std::vector<TriangleId> found;
            if ((word & edge_list_bit) == 0) {
                found = {TriangleId{incidence::triangle(index.parts().edge_incidences()[edge])},
                         index.parts().id(word)};
            } else {
                const std::uint32_t first = word & ~edge_list_bit;
                for (const std::uint32_t row :
                     signs.edge_lists.subspan(first + 1, signs.edge_lists[first]))
                    found.push_back(index.parts().id(row));
                ++lists;
            }
            EXPECT_EQ(found, truth) << "edge " << edge;
        }
    }
    EXPECT_EQ(lists, 1U);
}

TEST(WithSigns, OfOpenMeshesHoldWindingNumbersAlone)
{
    const TriangleMesh mesh =
        without(sphere_mesh(Vec3::Zero(), 1.0, 20, 30), [](std::size_t i) { return i < 90; });
    const MeshIndex index = with_signs(build_mesh_index(mesh).value()).value();
    const SignArrays& signs = index.parts().signs()->arrays();
    EXPECT_TRUE(signs.sides.empty());
    EXPECT_TRUE(signs.vertices.empty());
    EXPECT_TRUE(signs.edges.empty());
    EXPECT_EQ(signs.rows.size(), mesh.triangle_count());
    EXPECT_FALSE(has_local_signs(index));
    EXPECT_EQ(signed_distance(index, Vec3(0.01, 0, -0.5))->method, SignMethod::winding_number);
}

TEST(WithSigns, ReportErrors)
{
    EXPECT_EQ(code_of(with_signs(MeshIndex())), ErrorCode::invalid_mesh);
    const MeshIndex index = build_mesh_index(torus_mesh(1.0, 0.3, 12, 8)).value();
    EXPECT_EQ(code_of(with_signs(index, {.execution = {.budget = {1000}}})),
              ErrorCode::budget_exceeded);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return with_signs(index, {.execution = {.threads = {1}, .progress = &progress}});
        },
        [] { return true; });
}

} // namespace
} // namespace proxima::build_signs_test
