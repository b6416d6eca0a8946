#include "thesis/octree_generation/overlap_as_printed.h"

#include "octree/same_cells.h"
#include "proxima/octree.h"
#include "proxima/sample_meshes.h"

#include <gtest/gtest.h>

namespace proxima::overlap_as_printed_test {
namespace {

constexpr PrintedRules put_right{.first_vertex = FirstVertex::in_both_lists,
                                 .offers = ListOffers::both_lists};

OctreeStatistics sphere_statistics(const PrintedRules& rules)
{
    const auto octree = build_octree_as_printed(
        make_sphere(100, 100), rules, {.max_depth = 1, .classification = Classification::none});
    return octree_statistics(octree.value());
}

TEST(OverlapAsPrinted, LosesTheFacetsThatRestOnTheFirstVertex)
{
    // The first vertex of this triangle is lowest in y and z: with the first vertex of the cube it
    // is v_1, and the planes of -y and -z keep fewer than three vertices.
    const Triangle triangle{{Vec3(0, 0, 0), Vec3(1, 0.25, 0.5), Vec3(0.25, 1, 0.75)}};
    AsPrintedTest<double> printed(triangle);
    AsPrintedTest<double> right(triangle, put_right);
    printed.set_half_size(Vec3::Constant(0.5));
    right.set_half_size(Vec3::Constant(0.5));
    EXPECT_LT(printed.plane_count(), right.plane_count());
    // Far below the triangle, where the planes of its other directions do not reach.
    std::size_t only_printed = 0;
    for (int x = -8; x <= 8; ++x) {
        for (int y = -8; y <= 8; ++y) {
            for (int z = -8; z <= 8; ++z) {
                const Vec3 centre(0.25 * x, 0.25 * y, 0.25 * z);
                EXPECT_TRUE(printed.overlap(centre).overlaps || !right.overlap(centre).overlaps);
                only_printed +=
                    printed.overlap(centre).overlaps && !right.overlap(centre).overlaps ? 1U : 0U;
            }
        }
    }
    EXPECT_GT(only_printed, 0U);
}

TEST(OverlapAsPrinted, MakesTheSphereOfTable21ListTrianglesThatDoNotTouch)
{
    constexpr std::uint64_t exact = 22392;
    EXPECT_GT(sphere_statistics({}).references, exact);
    EXPECT_GT(sphere_statistics({.width = FloatWidth::float_32}).references, exact);
    // The excess is the first vertex's alone: it goes when v_1 is in both lists.
    EXPECT_EQ(sphere_statistics({.first_vertex = FirstVertex::in_both_lists}).references, exact);
    EXPECT_EQ(sphere_statistics(put_right).references, exact);
    EXPECT_GT(sphere_statistics({.first_vertex = FirstVertex::in_maximal_list}).references, exact);
}

} // namespace
} // namespace proxima::overlap_as_printed_test
