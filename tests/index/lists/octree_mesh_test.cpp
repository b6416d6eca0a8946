// The mesh of an octree's rows is the one that the octree was built of; crafted rows are refused.
#include "index/lists/octree_mesh.h"

#include "index/lists/build_proximity_octree.h"
#include "index/test_meshes.h"

#include <bit>
#include <gtest/gtest.h>

namespace proxima {
namespace {

ProximityOctree built(const TriangleMesh& mesh)
{
    auto octree =
        build_proximity_octree(mesh, {.budget_bytes = 600 * mesh.triangle_count() + 4096});
    EXPECT_TRUE(octree) << describe(octree.error());
    return std::move(*octree);
}

TEST(OctreeMesh, IsTheMeshThatItWasBuiltOf)
{
    bool has_floats = false;
    bool has_doubles = false;
    for (const testing::NamedMesh& named : testing::proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const ProximityOctree octree = built(named.mesh);
        has_floats = has_floats || !octree.arrays().float_rows.empty();
        has_doubles = has_doubles || !octree.arrays().double_rows.empty();
        const auto mesh = mesh_of(octree);
        ASSERT_TRUE(mesh) << describe(mesh.error());
        ASSERT_TRUE(std::ranges::equal(mesh->triangles(), named.mesh.triangles()));
        ASSERT_EQ(mesh->vertex_count(), named.mesh.vertex_count());
        const Topology topology = build_topology(*mesh).value();
        for (std::uint32_t i = 0; i < mesh->vertex_count(); ++i) {
            const VertexId vertex{i};
            const Vec3& expected = topology.triangles(vertex).empty() ? octree.frame().center
                                                                      : named.mesh.position(vertex);
            for (int k = 0; k < 3; ++k) {
                ASSERT_EQ(std::bit_cast<std::uint64_t>(mesh->position(vertex)[k]),
                          std::bit_cast<std::uint64_t>(expected[k]))
                    << "vertex " << i;
            }
        }
        const Status same = check_edges(octree, topology);
        ASSERT_TRUE(same) << describe(same.error());
    }
    EXPECT_TRUE(has_floats && has_doubles);
}

/// An octree with its rows copied, for tests that change them.
struct EditableRows {
    ProximityOctree octree;
    std::vector<TriangleRow<float>> rows{octree.arrays().float_rows.begin(),
                                         octree.arrays().float_rows.end()};
    std::vector<std::uint32_t> edge_places{octree.arrays().edge_places.begin(),
                                           octree.arrays().edge_places.end()};

    [[nodiscard]] ProximityOctree changed() const
    {
        ProximityArrays arrays = octree.arrays();
        arrays.float_rows = rows;
        arrays.edge_places = edge_places;
        return ProximityOctree::adopt(octree.frame(), octree.table_depth(), arrays, &octree.tree(),
                                      octree.statistics(), octree.mesh_fingerprint(), nullptr);
    }
};

TEST(OctreeMesh, RefusesRowsThatContradictEachOther)
{
    const EditableRows whole{built(sample_mesh("cube").value())};
    ASSERT_FALSE(whole.rows.empty());
    const auto message = [](const EditableRows& edited) {
        const ProximityOctree octree = edited.changed();
        const auto mesh = mesh_of(octree);
        if (!mesh) return describe(mesh.error());
        const Status same = check_edges(octree, build_topology(*mesh).value());
        return same ? std::string() : describe(same.error());
    };
    EXPECT_EQ(message(whole), "");
    EditableRows edited = whole;
    edited.rows[3].coordinates[1][2] += 0.25F;
    EXPECT_NE(message(edited).find("a vertex at two places"), std::string::npos);
    edited = whole;
    std::swap(edited.rows[3].triangle, edited.rows[4].triangle);
    EXPECT_NE(message(edited).find("not those of the mesh"), std::string::npos);
    edited = whole;
    std::swap(edited.rows[3].edges[0], edited.rows[3].edges[1]);
    EXPECT_NE(message(edited).find("another numbering"), std::string::npos);
    edited = whole;
    edited.edge_places.push_back(0);
    EXPECT_NE(message(edited).find("edges of another mesh"), std::string::npos);
}

} // namespace
} // namespace proxima
