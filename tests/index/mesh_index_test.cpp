#include "proxima/mesh_index.h"

#include "cancellation.h"
#include "code_of.h"
#include "index/index_parts.h"
#include "index/test_meshes.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>

namespace proxima::mesh_index_test {
namespace {

using namespace testing;

/// Walks all blocks: every box holds what is below it with its margin, every triangle is there
/// once, and its floats are those of its row.
class Inspection {
public:
    Inspection(const MeshIndex& index, const TriangleMesh& mesh) : index_(index), mesh_(mesh)
    {
        seen_.assign(mesh.triangle_count(), 0);
        visit(index.parts().root(), Box{Vec3::Constant(-2), Vec3::Constant(2)}, 0);
        for (const int times : seen_) EXPECT_EQ(times, 1);
        check_places();
    }
    std::size_t levels = 0;

private:
    void visit(std::uint32_t reference, const Box& box, std::size_t level)
    {
        levels = std::max(levels, level + 1);
        const IndexBlock& block = index_.parts().blocks()[reference & ~index_leaf_bit];
        if ((reference & index_leaf_bit) != 0) {
            visit_leaf(block.leaf, box);
            return;
        }
        const IndexNode& node = block.node;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            Box child;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                const auto plane = [&](std::uint8_t byte) {
                    return double{node.origin[axis]} + (32768.0 + byte) * double{node.step[axis]};
                };
                child.lower[k] = plane(node.planes[axis][slot]);
                child.upper[k] = plane(node.planes[axis][8 + slot]);
            }
            if (child.empty()) {
                EXPECT_EQ(index_.parts().blocks()[node.children[slot] & ~index_leaf_bit].leaf.count,
                          0);
            } else {
                visit(node.children[slot], child, level + 1);
            }
        }
    }
    void visit_leaf(const IndexLeaf& leaf, const Box& box)
    {
        ASSERT_GT(leaf.count, 0);
        ASSERT_LE(leaf.count, 8);
        const auto extent =
            std::bit_cast<float>(static_cast<std::uint32_t>(leaf.extent_bits) << 16U);
        for (std::uint32_t i = 0; i < leaf.count; ++i) {
            const std::uint32_t row = leaf.first_row + i;
            const TriangleId id = index_.ids()[row];
            ASSERT_LT(to_index(id), mesh_.triangle_count());
            ++seen_[to_index(id)];
            check_names(row, id);
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const Vec3 p = mesh_.triangle(id).vertices[corner];
                EXPECT_EQ(index_.parts().triangle(row).vertices[corner], p);
                const Vec3 place = (p - index_.parts().center()) * index_.parts().scale();
                for (int axis = 0; axis < 3; ++axis) {
                    constexpr double margin = 0x1p-21;
                    EXPECT_LE(box.lower[axis] + margin, place[axis]);
                    EXPECT_GE(box.upper[axis] - margin, place[axis]);
                    const float stored =
                        leaf.coordinates[static_cast<std::size_t>(axis)][leaf.corners[corner][i]];
                    EXPECT_EQ(stored, static_cast<float>(place[axis]));
                    if (index_.parts().has_exact_leaves()) {
                        EXPECT_EQ(stored / index_.parts().scale() + index_.parts().center()[axis],
                                  p[axis]);
                    }
                }
            }
        }
        EXPECT_GE(double{extent}, std::min(box.extent().maxCoeff(), 2.1));
    }

    /// A row names its triangle, vertices and edges as the topology does, and knows which sides go
    /// from their higher to their lower vertex.
    void check_names(std::uint32_t row, TriangleId id)
    {
        if (index_.parts().float_rows().empty()) {
            check_names(index_.parts().double_rows()[row], id);
        } else {
            check_names(index_.parts().float_rows()[row], id);
        }
    }
    template <class Scalar>
    void check_names(const TriangleRow<Scalar>& row, TriangleId id)
    {
        EXPECT_EQ(row.triangle_id(), to_index(id));
        const TriangleCorners& corners = mesh_.triangles()[to_index(id)];
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(row.vertices[k], corners[k]);
            EXPECT_EQ(EdgeId{row.edges[k]}, topology_.edges(id)[k]);
            EXPECT_EQ(row.backward(k), corners[k] > corners[(k + 1) % 3]);
        }
    }
    /// Every vertex and edge is found at its lowest triangle.
    void check_places()
    {
        ASSERT_EQ(index_.vertex_count(), topology_.vertex_count());
        ASSERT_EQ(index_.edge_count(), topology_.edge_count());
        for (std::uint32_t i = 0; i < index_.vertex_count(); ++i) {
            const std::span<const TriangleId> star = topology_.triangles(VertexId{i});
            const std::uint32_t place = index_.parts().vertex_incidences()[i];
            if (star.empty()) {
                EXPECT_EQ(place, incidence::none);
                continue;
            }
            EXPECT_EQ(TriangleId{incidence::triangle(place)}, star.front());
            EXPECT_EQ(mesh_.triangles()[incidence::triangle(place)][incidence::corner(place)], i);
        }
        for (std::uint32_t i = 0; i < index_.edge_count(); ++i) {
            const std::uint32_t place = index_.parts().edge_incidences()[i];
            const std::uint32_t triangle = incidence::triangle(place);
            EXPECT_EQ(TriangleId{triangle}, topology_.triangles(EdgeId{i}).front());
            const std::size_t side = incidence::corner(place);
            EXPECT_EQ(topology_.edges(TriangleId{triangle})[side], EdgeId{i});
            const TriangleCorners& corners = mesh_.triangles()[triangle];
            EXPECT_EQ(incidence::backward(place), corners[side] > corners[(side + 1) % 3]);
        }
    }

    const MeshIndex& index_;
    const TriangleMesh& mesh_;
    Topology topology_ = build_topology(mesh_).value();
    std::vector<int> seen_;
};

TEST(MeshIndex, HoldsEveryTriangleOnceWithinItsBoxes)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const MeshIndex index = build_mesh_index(named.mesh).value();
        const Inspection inspection(index, named.mesh);
        EXPECT_LE(inspection.levels, IndexParts::max_levels);
    }
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        const MeshIndex index = build_mesh_index(mesh).value();
        const Inspection inspection(index, mesh);
    }
}

TEST(MeshIndex, AcceptsManyCoincidentTriangles)
{
    const std::vector<Vec3> positions = {{1, 2, 3}, {2, 2, 3}, {1, 3, 3}};
    const TriangleMesh mesh = mesh_of(positions, std::vector<TriangleCorners>(5000, {0, 1, 2}));
    const MeshIndex index = build_mesh_index(mesh).value();
    const Inspection inspection(index, mesh);
    EXPECT_LE(inspection.levels, 6U);
}

TEST(MeshIndex, StoresFloatsWhenTheyAreExact)
{
    const TriangleMesh cube = cube_mesh(Vec3(1, 2, 3), 0.5);
    EXPECT_EQ(build_mesh_index(cube)->parts().float_rows().size(), 12U);
    const TriangleMesh third = cube_mesh(Vec3(1, 2, 3), 1.0 / 3);
    EXPECT_EQ(build_mesh_index(third)->parts().double_rows().size(), 12U);
}

TEST(MeshIndex, HasExactLeavesForFloatCoordinatesAnywhere)
{
    std::mt19937 random(5);
    for (const Vec3& place : {Vec3(0, 0, 0), Vec3(0.2, 3, -1000), Vec3(-0.6, 1e6, 0.9)}) {
        std::vector<Vec3> positions(300);
        for (Vec3& p : positions) {
            for (int axis = 0; axis < 3; ++axis) {
                std::uniform_real_distribution<float> around(
                    static_cast<float>(place[axis]) - 0.5F, static_cast<float>(place[axis]) + 0.5F);
                p[axis] = double{around(random)};
            }
        }
        std::vector<TriangleCorners> triangles;
        for (std::uint32_t i = 0; i + 2 < positions.size(); ++i)
            triangles.push_back({i, i + 1, i + 2});
        const TriangleMesh mesh = mesh_of(positions, triangles);
        const MeshIndex index = build_mesh_index(mesh).value();
        EXPECT_TRUE(index.parts().has_exact_leaves());
        const Inspection inspection(index, mesh);
        positions[7][1] += 1e-12; // no float
        const TriangleMesh other = mesh_of(positions, triangles);
        if (other.positions()[7] == mesh.positions()[7]) continue;
        EXPECT_FALSE(build_mesh_index(other)->parts().has_exact_leaves());
    }
}

TEST(MeshIndex, IsBuiltFarFromTheOrigin)
{
    for (const double far : {1e9, 1e11, 1e12, 1e13, 1e15, 1e100, 1e300}) {
        const TriangleMesh mesh =
            make_triangle_mesh({Vec3(far, 0, 3), Vec3(far + 6, far, 6), Vec3(far - 6, 6, 1)},
                               {{0, 1, 2}})
                .value();
        EXPECT_EQ(build_mesh_index(mesh).value().triangle_count(), 1U) << far;
    }
}

TEST(MeshIndex, IsTheSameForAnyNumberOfThreads)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 100, 80);
    const MeshIndex truth = build_mesh_index(torus, {.execution = {.threads = {1}}}).value();
    for (const int threads : {2, 3}) {
        const MeshIndex other =
            build_mesh_index(torus, {.execution = {.threads = {threads}}}).value();
        const auto is_same = [](const auto& a, const auto& b) {
            return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
        };
        ASSERT_EQ(other.parts().blocks().size(), truth.parts().blocks().size());
        for (std::size_t i = 0; i < truth.parts().blocks().size(); ++i) {
            // What nodes and leaves both use.
            ASSERT_EQ(std::memcmp(&other.parts().blocks()[i], &truth.parts().blocks()[i],
                                  sizeof(IndexLeaf)),
                      0);
        }
        EXPECT_TRUE(is_same(other.parts().double_rows(), truth.parts().double_rows()));
        EXPECT_TRUE(is_same(other.ids(), truth.ids()));
        EXPECT_TRUE(is_same(other.parts().vertex_incidences(), truth.parts().vertex_incidences()));
        EXPECT_TRUE(is_same(other.parts().edge_incidences(), truth.parts().edge_incidences()));
    }
}

TEST(MeshIndex, IsUsableWhenEmptyOrMovedFrom)
{
    const MeshIndex empty;
    EXPECT_EQ(empty.triangle_count(), 0U);
    EXPECT_EQ(empty.bytes(), 0U);
    EXPECT_TRUE(empty.ids().empty());
    EXPECT_FALSE(empty.has_lists());
    EXPECT_EQ(mesh_of(empty)->triangle_count(), 0U);
    EXPECT_EQ(code_of(with_lists(empty)), ErrorCode::invalid_mesh);
    EXPECT_FALSE(empty.has_slabs());
    MeshIndex index = build_mesh_index(cube_mesh(Vec3::Zero(), 1.0)).value();
    const MeshIndex taken = index;
    EXPECT_EQ(&index.parts(), &taken.parts()); // NOLINT(bugprone-use-after-move): that is the test
    EXPECT_EQ(taken.triangle_count(), 12U);
    index = empty;
    EXPECT_EQ(index.triangle_count(), 0U);
}

TEST(MeshIndex, RefusesInvalidMeshes)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    const auto code = [](const auto& result) { return result.error().code; };
    EXPECT_EQ(code(build_mesh_index(TriangleMesh())), ErrorCode::invalid_mesh);
    EXPECT_EQ(code(build_mesh_index(cube, {.execution = {.budget = {100}}})),
              ErrorCode::budget_exceeded);
    const TriangleMesh large = torus_mesh(1.0, 0.4, 120, 100);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return build_mesh_index(large, {.execution = {.progress = &progress}});
        },
        [] { return true; });
}

TEST(MeshIndex, KeepsFloatsOnlyWhereAllCoordinatesAreNormalOnes)
{
    const auto has_floats = [](double coordinate) {
        const TriangleMesh mesh =
            mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, coordinate, 1)}, {{0, 1, 2}});
        return !build_mesh_index(mesh).value().parts().float_rows().empty();
    };
    EXPECT_TRUE(has_floats(0.5));
    EXPECT_TRUE(has_floats(-0.0));
    EXPECT_TRUE(has_floats(0x1p-126));
    EXPECT_TRUE(has_floats(0x1.fffffep127));
    EXPECT_FALSE(has_floats(0x1p-127)); // a float, but not a normal one
    EXPECT_FALSE(has_floats(0x1p-1000));
    EXPECT_FALSE(has_floats(0x1p128));
    EXPECT_FALSE(has_floats(0.1));
}

} // namespace
} // namespace proxima::mesh_index_test
