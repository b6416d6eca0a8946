#include "thesis/octree_generation/operation_table.h"

#include "minkowski/operation_counts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

namespace proxima::operation_table_test {
namespace {

const OperationCountRow& row(const std::vector<OperationCountRow>& rows, const std::string& method)
{
    const auto found = std::ranges::find(rows, method, &OperationCountRow::method);
    EXPECT_NE(found, rows.end()) << method;
    return found == rows.end() ? rows.front() : *found;
}

TEST(OperationTable, ReproducesTable32)
{
    const auto rows = count_operations();
    for (const OperationCountRow& r : rows) {
        std::cout << r.method << ": " << r.counts.dot_products << " dot, "
                  << r.counts.cross_products << " cross, " << r.counts.flops() << " flops ("
                  << r.counts.additions << " + " << r.counts.subtractions << " - "
                  << r.counts.multiplications << " * " << r.counts.divisions << " /), "
                  << r.counts.comparisons << " comparisons, " << r.counts.negations << " negations";
        if (r.thesis) std::cout << "; thesis " << r.thesis->dot_products << ", " << r.thesis->flops;
        std::cout << "\n";
    }
    // As the thesis counts them.
    EXPECT_EQ(row(rows, "Separating-axis-based intersection").counts.dot_products, 13);
    EXPECT_EQ(row(rows, "Separating-axis-based intersection").counts.flops(), 83);
    // All 26 planes only for degenerate triangles; in general position 17 are facets.
    EXPECT_EQ(row(rows, "Minkowski-sum-based intersection").counts.dot_products, 26);
    EXPECT_EQ(row(rows, "Minkowski-sum-based intersection").counts.flops(), 130);
    const std::string general = "Minkowski-sum-based intersection, general position";
    EXPECT_EQ(row(rows, general).counts.dot_products, 17);
    EXPECT_EQ(row(rows, general).counts.flops(), 85);
    EXPECT_EQ(row(rows, "Index-tracking-based intersection").counts.flops(), 130);
    EXPECT_EQ(row(rows, "Index tracking, constants of a depth after the first").counts.flops(),
              26 * (3 + 5));
    // 1713 and the tests for three supports that are not collinear: for each of nine facets one
    // difference within the cube, three in the triangle's two directions, two cross products.
    const OperationCounts geometric = row(rows, "Geometric method, general position").counts;
    EXPECT_EQ(geometric.dot_products, 312);
    EXPECT_EQ(geometric.cross_products, 9 + 9 * 2);
    EXPECT_EQ(geometric.flops(), 1713 + 9 * (3 * 3 + 2 * 9));
    EXPECT_EQ(row(rows, "Geometric method").counts.dot_products, 312);
    // No pair needs all that the thesis adds up: a miss leaves t out of range or x out of a face.
    const OperationCounts pairwise = row(rows, "Pairwise intersection").counts;
    // The most that the pairs take: 81 dot products of five operations, 28 quotients t of two, 41
    // coordinates of hits of two, and six for the planes of the cell.
    EXPECT_EQ(pairwise.dot_products, 81);
    EXPECT_EQ(pairwise.divisions, 28);
    EXPECT_EQ(pairwise.flops(), 81 * 5 + 28 * 2 + 41 * 2 + 6);
    // The closed form: a fourth of the thesis's 130 and less than half of 83, then additions alone.
    EXPECT_EQ(row(rows, "Fast, constants of a triangle").counts.flops(), 61);
    EXPECT_EQ(row(rows, "Fast, constants of a depth").counts.flops(), 27);
    EXPECT_EQ(row(rows, "Fast, one cell").counts.flops(), 32);
    const OperationCounts children = row(rows, "Fast, all eight children of a cell").counts;
    EXPECT_EQ(children.flops(), 34);
    EXPECT_EQ(children.additions, 34);
    const OperationCounts child = row(rows, "Fast, going down to a child").counts;
    EXPECT_EQ(child.flops(), 21);
    EXPECT_EQ(child.additions, 21);
    EXPECT_GT(row(rows, "Incremental convex hull method").counts.flops(), geometric.flops());
}

TEST(OperationTable, IsTheSameEveryTime)
{
    const auto first = count_operations({.pairs = 100});
    const auto second = count_operations({.pairs = 100});
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(first[i].method, second[i].method);
        EXPECT_EQ(first[i].counts, second[i].counts);
    }
}

} // namespace
} // namespace proxima::operation_table_test
