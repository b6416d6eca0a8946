// The slabs of a mesh index hold what lies below them.
#include "proxima/mesh_index.h"

#include "cancellation.h"
#include "code_of.h"
#include "index/index_parts.h"
#include "index/slabs/block_slab.h"
#include "index/test_meshes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace proxima::build_slabs_test {
namespace {

using namespace testing;

/// Every vertex below a block lies between the planes of its slab.
class SlabInspection {
public:
    explicit SlabInspection(const MeshIndex& index) : index_(index)
    {
        visit(index.parts().root(), Vec3::Zero(), Vec3::Constant(1.01), {});
    }
    std::size_t thin = 0; ///< slabs that are less than half of their box

private:
    struct Plane {
        Vec3 center;
        Vec3 normal;
        double lower;
        double upper;
    };

    Plane plane_of(const BlockSlab& slab, const Vec3& center, const Vec3& half)
    {
        const auto part = [](std::uint32_t word, unsigned shift, unsigned bits) {
            const std::int64_t raw = word >> shift & ((1U << bits) - 1);
            return static_cast<double>(raw >> (bits - 1) != 0 ? raw - (1LL << bits) : raw);
        };
        Plane plane = {center, {}, 0, 0};
        for (unsigned k = 0; k < 3; ++k) plane.normal[k] = part(slab.normal, 22 - 10 * k, 10) / 512;
        const double reach = plane.normal.cwiseAbs().dot(half);
        plane.upper = reach * part(slab.extent, 16, 16) / 32768;
        plane.lower = reach * part(slab.extent, 0, 16) / 32768;
        thin += plane.upper - plane.lower < reach ? 1 : 0;
        return plane;
    }
    void visit(std::uint32_t reference, const Vec3& center, const Vec3& half,
               std::vector<Plane> above)
    {
        const IndexBlock& block = index_.parts().blocks()[reference & ~index_leaf_bit];
        if ((reference & index_leaf_bit) == 0 || block.leaf.count > 0) {
            above.push_back(
                plane_of(index_.parts().slabs()[reference & ~index_leaf_bit], center, half));
        }
        if ((reference & index_leaf_bit) != 0) {
            visit_leaf(block.leaf, above);
            return;
        }
        for (std::size_t slot = 0; slot < 8; ++slot) {
            Vec3 lower;
            Vec3 upper;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto plane = [&](std::uint8_t byte) {
                    return double{block.node.origin[axis]} +
                           (32768.0 + byte) * double{block.node.step[axis]};
                };
                lower[static_cast<Eigen::Index>(axis)] = plane(block.node.planes[axis][slot]);
                upper[static_cast<Eigen::Index>(axis)] = plane(block.node.planes[axis][8 + slot]);
            }
            visit(block.node.children[slot], 0.5 * (lower + upper), 0.5 * (upper - lower), above);
        }
    }
    void visit_leaf(const IndexLeaf& leaf, const std::vector<Plane>& above)
    {
        for (std::uint32_t i = leaf.first_row; i < leaf.first_row + leaf.count; ++i) {
            for (const Vec3& vertex : index_.parts().triangle(i).vertices) {
                const Vec3 p = (vertex - index_.parts().center()) * index_.parts().scale();
                for (const Plane& plane : above) {
                    const double on = plane.normal.dot(p - plane.center);
                    ASSERT_GE(on, plane.lower);
                    ASSERT_LE(on, plane.upper);
                }
            }
        }
    }

    const MeshIndex& index_;
};

TEST(Slabs, BoundTheTrianglesOfTheirBlocks)
{
    std::size_t thin = 0;
    for (const NamedMesh& named : proximity_meshes()) {
        SCOPED_TRACE(named.name);
        const MeshIndex index = with_slabs(build_mesh_index(named.mesh).value()).value();
        thin += SlabInspection(index).thin;
    }
    EXPECT_GT(thin, 100U);
}

TEST(Slabs, AreTheSameForAnyNumberOfThreadsAndStopOnRequest)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 100, 80);
    const MeshIndex triangles = build_mesh_index(torus).value();
    const MeshIndex truth = with_slabs(triangles, {.execution = {.threads = {1}}}).value();
    const MeshIndex other = with_slabs(triangles, {.execution = {.threads = {3}}}).value();
    ASSERT_EQ(other.parts().slabs().size(), truth.parts().slabs().size());
    EXPECT_EQ(std::memcmp(other.parts().slabs().data(), truth.parts().slabs().data(),
                          truth.parts().slabs().size_bytes()),
              0);
    EXPECT_EQ(code_of(with_slabs(triangles, {.execution = {.budget = {100}}})),
              ErrorCode::budget_exceeded);
    cancel_at_every_stage(
        [&](Progress& progress) {
            return with_slabs(triangles, {.execution = {.progress = &progress}});
        },
        [] { return true; });
    EXPECT_TRUE(with_slabs(MeshIndex()).has_value());
}

} // namespace
} // namespace proxima::build_slabs_test
