#include "proxima/mesh_repair.h"

#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>
#include <random>
#include <set>

namespace proxima::sub_mesh_test {
namespace {

TEST(SubMesh, HasOnlyTheRequestedTrianglesAndTheirVertices)
{
    const TriangleMesh mesh = sample_mesh("torus:12x7").value();
    for (std::uint32_t seed = 0; seed < 50; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        std::vector<TriangleId> chosen(random() % 40);
        for (TriangleId& id : chosen)
            id = TriangleId{static_cast<std::uint32_t>(random() % mesh.triangle_count())};
        const TriangleMesh part = sub_mesh(mesh, chosen);
        ASSERT_EQ(part.triangle_count(), chosen.size());
        std::set<std::uint32_t> used;
        for (std::uint32_t i = 0; i < chosen.size(); ++i) {
            for (int k = 0; k < 3; ++k)
                EXPECT_EQ(part.triangle(TriangleId{i})[k], mesh.triangle(chosen[i])[k]);
            for (const std::uint32_t vertex : mesh.triangles()[to_index(chosen[i])])
                used.insert(vertex);
        }
        // In their order, each once.
        ASSERT_EQ(part.vertex_count(), used.size());
        std::uint32_t place = 0;
        for (const std::uint32_t vertex : used)
            EXPECT_EQ(part.position(VertexId{place++}), mesh.position(VertexId{vertex}));
    }
}

} // namespace
} // namespace proxima::sub_mesh_test
