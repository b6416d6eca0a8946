#include "index/mesh_index.h"

#include "cancellation.h"
#include "index/build_mesh_index.h"
#include "index/test_meshes.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/octree.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <random>

namespace proxima {
namespace {

using namespace testing;

Octree octree_of(const TriangleMesh& mesh)
{
    return build_octree(mesh, {.max_depth = 3, .classification = Classification::none}).value();
}

Triangle row_triangle(const MeshIndex& index, std::uint32_t row)
{
    return index.float_rows().empty() ? index.double_rows()[row].triangle()
                                      : index.float_rows()[row].triangle();
}

std::uint32_t row_id(const MeshIndex& index, std::uint32_t row)
{
    return index.float_rows().empty() ? index.double_rows()[row].id : index.float_rows()[row].id;
}

/// Walks all blocks: every box holds what is below it with its margin, every triangle is there
/// once, and its floats are those of its row.
class Inspection {
public:
    Inspection(const MeshIndex& index, const TriangleMesh& mesh) : index_(index), mesh_(mesh)
    {
        seen_.assign(mesh.triangle_count(), 0);
        visit(index.root(), Box{Vec3::Constant(-2), Vec3::Constant(2)}, 0);
        for (const int times : seen_) EXPECT_EQ(times, 1);
    }
    std::size_t levels = 0;

private:
    void visit(std::uint32_t reference, const Box& box, std::size_t level)
    {
        levels = std::max(levels, level + 1);
        const IndexBlock& block = index_.blocks()[reference & ~index_leaf_bit];
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
                EXPECT_EQ(index_.blocks()[node.children[slot] & ~index_leaf_bit].leaf.count, 0);
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
            ASSERT_LT(row_id(index_, row), mesh_.triangle_count());
            const TriangleId id{row_id(index_, row)};
            EXPECT_EQ(index_.ids()[row], id);
            ++seen_[row_id(index_, row)];
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const Vec3 p = mesh_.triangle(id).vertices[corner];
                EXPECT_EQ(row_triangle(index_, row).vertices[corner], p);
                const Vec3 place = (p - index_.center()) * index_.scale();
                for (int axis = 0; axis < 3; ++axis) {
                    constexpr double margin = 0x1p-21;
                    EXPECT_LE(box.lower[axis] + margin, place[axis]);
                    EXPECT_GE(box.upper[axis] - margin, place[axis]);
                    const float stored =
                        leaf.coordinates[static_cast<std::size_t>(axis)][leaf.corners[corner][i]];
                    EXPECT_EQ(stored, static_cast<float>(place[axis]));
                    if (index_.has_exact_leaves()) {
                        EXPECT_EQ(stored / index_.scale() + index_.center()[axis], p[axis]);
                    }
                }
            }
        }
        EXPECT_GE(double{extent}, std::min(box.extent().maxCoeff(), 2.1));
    }

    const MeshIndex& index_;
    const TriangleMesh& mesh_;
    std::vector<int> seen_;
};

TEST(MeshIndex, HoldsEveryTriangleOnceWithinItsBoxes)
{
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const MeshIndex index = build_mesh_index(octree_of(named.mesh), named.mesh).value();
        const Inspection inspection(index, named.mesh);
        EXPECT_LE(inspection.levels, MeshIndex::max_levels);
    }
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = nasty_mesh(seed);
        const MeshIndex index = build_mesh_index(octree_of(mesh), mesh).value();
        const Inspection inspection(index, mesh);
    }
}

TEST(MeshIndex, TakesManyTrianglesInOnePlace)
{
    const std::vector<Vec3> positions = {{1, 2, 3}, {2, 2, 3}, {1, 3, 3}};
    const TriangleMesh mesh = mesh_of(positions, std::vector<TriangleCorners>(5000, {0, 1, 2}));
    const MeshIndex index = build_mesh_index(octree_of(mesh), mesh).value();
    const Inspection inspection(index, mesh);
    EXPECT_LE(inspection.levels, 6U);
}

TEST(MeshIndex, KeepsFloatsWhereTheyAreTheSame)
{
    const TriangleMesh cube = cube_mesh(Vec3(1, 2, 3), 0.5);
    EXPECT_EQ(build_mesh_index(octree_of(cube), cube)->float_rows().size(), 12U);
    const TriangleMesh third = cube_mesh(Vec3(1, 2, 3), 1.0 / 3);
    EXPECT_EQ(build_mesh_index(octree_of(third), third)->double_rows().size(), 12U);
}

TEST(MeshIndex, HasExactLeavesOfFloatsWhereverTheyLie)
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
        const MeshIndex index = build_mesh_index(octree_of(mesh), mesh).value();
        EXPECT_TRUE(index.has_exact_leaves());
        const Inspection inspection(index, mesh);
        positions[7][1] += 1e-12; // no float
        const TriangleMesh other = mesh_of(positions, triangles);
        if (other.positions()[7] == mesh.positions()[7]) continue;
        EXPECT_FALSE(build_mesh_index(octree_of(other), other)->has_exact_leaves());
    }
}

TEST(MeshIndex, IsTheSameForAnyNumberOfThreadsAndAnyDepthOfTheOctree)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 100, 80);
    const auto build = [&](int threads, int depth) {
        const auto octree =
            build_octree(torus, {.max_depth = depth, .classification = Classification::none});
        return build_mesh_index(*octree, torus, {.execution = {.threads = {threads}}}).value();
    };
    const MeshIndex truth = build(1, 5);
    for (const auto& [threads, depth] : {std::pair(2, 5), std::pair(3, 0), std::pair(1, 8)}) {
        const MeshIndex other = build(threads, depth);
        ASSERT_EQ(other.blocks().size(), truth.blocks().size());
        for (std::size_t i = 0; i < truth.blocks().size(); ++i)
            ASSERT_EQ(std::memcmp(&other.blocks()[i], &truth.blocks()[i], 104), 0);
        ASSERT_EQ(other.double_rows().size(), truth.double_rows().size());
        for (std::size_t i = 0; i < truth.double_rows().size(); ++i)
            ASSERT_EQ(other.double_rows()[i].id, truth.double_rows()[i].id);
    }
}

TEST(MeshIndex, RefusesWhatItCannotBeBuiltOf)
{
    const TriangleMesh cube = cube_mesh(Vec3::Zero(), 1.0);
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 10, 8);
    const auto code = [](const auto& result) { return result.error().code; };
    EXPECT_EQ(code(build_mesh_index(octree_of(torus), cube)), ErrorCode::invalid_argument);
    EXPECT_EQ(code(build_mesh_index(octree_of(cube), TriangleMesh())), ErrorCode::invalid_mesh);
    EXPECT_EQ(code(build_mesh_index(Octree(), cube)), ErrorCode::invalid_argument);
    EXPECT_EQ(code(build_mesh_index(octree_of(cube), cube, {.execution = {.budget = {100}}})),
              ErrorCode::budget_exceeded);
    const TriangleMesh large = torus_mesh(1.0, 0.4, 120, 100);
    const Octree octree = octree_of(large);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return build_mesh_index(octree, large, {.execution = {.progress = &progress}});
        },
        [] { return true; });
}

} // namespace
} // namespace proxima
