// The mesh of an index's rows is the one that the index was built of; crafted rows are refused.
#include "proxima/mesh_index.h"

#include "base/text.h"
#include "code_of.h"
#include "index/check_edges.h"
#include "index/index_parts.h"
#include "index/test_meshes.h"
#include "index/triangle_row.h"

#include <bit>
#include <gtest/gtest.h>

namespace proxima::mesh_of_test {
namespace {

TEST(MeshOf, ReturnsTheMeshThatTheIndexWasBuiltFrom)
{
    bool has_floats = false;
    bool has_doubles = false;
    for (const testing::NamedMesh& named : testing::proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const MeshIndex built = build_mesh_index(named.mesh).value();
        has_floats = has_floats || !built.parts().float_rows().empty();
        has_doubles = has_doubles || !built.parts().double_rows().empty();
        const auto mesh = mesh_of(built);
        ASSERT_TRUE(mesh) << describe(mesh.error());
        ASSERT_TRUE(std::ranges::equal(mesh->triangles(), named.mesh.triangles()));
        ASSERT_EQ(mesh->vertex_count(), named.mesh.vertex_count());
        const Topology topology = build_topology(*mesh).value();
        for (std::uint32_t i = 0; i < mesh->vertex_count(); ++i) {
            const VertexId vertex{i};
            const Vec3& expected = topology.triangles(vertex).empty() ? built.parts().center()
                                                                      : named.mesh.position(vertex);
            for (int k = 0; k < 3; ++k) {
                ASSERT_EQ(std::bit_cast<std::uint64_t>(mesh->position(vertex)[k]),
                          std::bit_cast<std::uint64_t>(expected[k]))
                    << "vertex " << i;
            }
        }
        const Status same = check_edges(built, topology);
        ASSERT_TRUE(same) << describe(same.error());
    }
    EXPECT_TRUE(has_floats && has_doubles);
}

/// An index with its rows copied, for tests that change them.
struct EditableRows {
    MeshIndex index;
    std::vector<TriangleRow<float>> rows{index.parts().float_rows().begin(),
                                         index.parts().float_rows().end()};
    std::vector<std::uint32_t> edge_incidences{index.parts().edge_incidences().begin(),
                                               index.parts().edge_incidences().end()};

    [[nodiscard]] MeshIndex changed() const
    {
        IndexArrays arrays;
        arrays.center = index.parts().center();
        arrays.scale = index.parts().scale();
        arrays.fingerprint = index.mesh_fingerprint();
        arrays.root = index.parts().root();
        arrays.blocks = index.parts().blocks();
        arrays.float_rows = rows;
        arrays.ids = index.ids();
        arrays.vertex_incidences = index.parts().vertex_incidences();
        arrays.edge_incidences = edge_incidences;
        return make_mesh_index(IndexParts::adopt(arrays, nullptr));
    }
};

TEST(MeshOf, RefusesRowsThatContradictEachOther)
{
    const EditableRows whole{build_mesh_index(sample_mesh("cube").value()).value()};
    ASSERT_FALSE(whole.rows.empty());
    const auto message = [](const EditableRows& edited) {
        const MeshIndex built = edited.changed();
        const auto mesh = mesh_of(built);
        if (!mesh) return describe(mesh.error());
        const Status same = check_edges(built, build_topology(*mesh).value());
        return same ? std::string() : describe(same.error());
    };
    EXPECT_EQ(message(whole), "");
    EditableRows edited = whole;
    edited.rows[3].coordinates[1][2] += 0.25F;
    EXPECT_NE(message(edited).find("a vertex at two positions"), std::string::npos);
    edited = whole;
    std::swap(edited.rows[3].triangle, edited.rows[4].triangle);
    EXPECT_NE(message(edited).find("not those of the mesh"), std::string::npos);
    edited = whole;
    std::swap(edited.rows[3].edges[0], edited.rows[3].edges[1]);
    EXPECT_NE(message(edited).find("another numbering"), std::string::npos);
    edited = whole;
    edited.edge_incidences.push_back(0);
    EXPECT_NE(message(edited).find("edges of another mesh"), std::string::npos);
}

TEST(MeshOf, DetectsAnotherMesh)
{
    const TriangleMesh cube = sample_mesh("cube").value();
    const MeshIndex index = build_mesh_index(cube).value();
    ASSERT_TRUE(check_same_mesh(index, cube));
    const TriangleMesh larger =
        testing::moved(cube, [](const Vec3& p) { return Vec3(p * (1 + 0x1p-50)); });
    const TriangleMesh sphere = sample_mesh("sphere:8x8").value();
    for (const TriangleMesh* other : {&larger, &sphere}) {
        const Status status = check_same_mesh(index, *other);
        ASSERT_FALSE(status);
        EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
        EXPECT_NE(status.error().message.find(" 12 triangles"), std::string::npos)
            << status.error().message;
        EXPECT_NE(status.error().message.find(
                      concat(other->triangle_count(), " triangles, ", other->vertex_count())),
                  std::string::npos)
            << status.error().message;
    }
}

} // namespace
} // namespace proxima::mesh_of_test
