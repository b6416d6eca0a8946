#include "mesh/triangle_order.h"

#include "base/hilbert_code.h"
#include "base/morton_code.h"
#include "proxima/sample_meshes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace proxima::triangle_order_test {
namespace {

/// The id of the cell that holds a triangle's centroid.
std::uint64_t code_of(const Triangle& triangle, const Box& bounds, SpaceCurve curve)
{
    const double cells = std::ldexp(1.0, triangle_order_bits);
    std::array<std::uint32_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
        const double centroid = (triangle[0][axis] + triangle[1][axis] + triangle[2][axis]) / 3;
        const double cell =
            std::floor((centroid - bounds.lower[axis]) / bounds.extent().maxCoeff() * cells);
        at[static_cast<std::size_t>(axis)] =
            static_cast<std::uint32_t>(std::min(std::max(cell, 0.0), cells - 1));
    }
    return curve == SpaceCurve::morton ? morton_code(at) : hilbert_code(at, triangle_order_bits);
}

TEST(TriangleOrder, SortsTrianglesAlongTheCurve)
{
    const TriangleMesh mesh = sample_mesh("spaceship:3000").value();
    for (const SpaceCurve curve : {SpaceCurve::morton, SpaceCurve::hilbert}) {
        const auto items = triangle_order(mesh, bounding_box(mesh), curve, nullptr);
        ASSERT_TRUE(items);
        std::vector<bool> seen(mesh.triangle_count(), false);
        int same_cell = 0;
        for (std::size_t rank = 0; rank < items->size(); ++rank) {
            const KeyedIndex& item = (*items)[rank];
            EXPECT_FALSE(seen[item.index]);
            seen[item.index] = true;
            // Rounding may move a centroid on the border of cells.
            same_cell += item.key ==
                         code_of(mesh.triangle(TriangleId{item.index}), bounding_box(mesh), curve);
            if (rank == 0) continue;
            const KeyedIndex& previous = (*items)[rank - 1];
            EXPECT_TRUE(previous.key < item.key ||
                        (previous.key == item.key && previous.index < item.index));
        }
        EXPECT_EQ(items->size(), mesh.triangle_count());
        EXPECT_GT(same_cell, 2990);
    }
}

TEST(TriangleOrder, PutsASurfaceOfAFewDenormalNumbersInOneCell)
{
    const double tiny = std::numeric_limits<double>::denorm_min();
    const TriangleMesh mesh = *make_triangle_mesh(
        {Vec3(0, 0, 0), Vec3(3 * tiny, 0, 0), Vec3(0, 3 * tiny, 0)}, {{1, 2, 1}, {0, 0, 0}});
    for (const SpaceCurve curve : {SpaceCurve::morton, SpaceCurve::hilbert}) {
        const auto items = triangle_order(mesh, bounding_box(mesh), curve, nullptr);
        ASSERT_TRUE(items);
        EXPECT_EQ((*items)[0].index, 0);
        EXPECT_EQ((*items)[1].index, 1);
    }
}

TEST(TriangleOrder, AcceptsCoincidentTrianglesAndStopsOnRequest)
{
    const TriangleMesh point =
        *make_triangle_mesh({Vec3(1, 2, 3)}, std::vector<TriangleCorners>(5000, {0, 0, 0}));
    const auto items = triangle_order(point, bounding_box(point), SpaceCurve::hilbert, nullptr);
    ASSERT_TRUE(items);
    for (std::uint32_t i = 0; i < 5000; ++i) EXPECT_EQ((*items)[i].index, i);
    Progress progress;
    progress.cancel();
    EXPECT_FALSE(triangle_order(point, bounding_box(point), SpaceCurve::morton, &progress));
}

} // namespace
} // namespace proxima::triangle_order_test
