#include "minkowski/operation_counts.h"

#include "minkowski/scalar_vector.h"

#include <gtest/gtest.h>

#include <thread>

namespace proxima::operation_counts_test {
namespace {

TEST(OperationCounts, CountEachKindSeparately)
{
    reset_operation_counts();
    Counted a = 3;
    const Counted b = 2;
    const Counted results[] = {a + b, a - b, a * b, a / b, -a, abs(-a)};
    a += b;
    a -= b;
    a *= b;
    a /= b;
    const bool outcomes[] = {a<b, a <= b, a> b, a >= b, a == b, a != b};
    const OperationCounts counts = operation_counts();
    EXPECT_EQ(counts, (OperationCounts{.additions = 2,
                                       .subtractions = 2,
                                       .multiplications = 2,
                                       .divisions = 2,
                                       .negations = 3,
                                       .comparisons = 6}));
    EXPECT_EQ(counts.flops(), 8);

    const double expected[] = {5, 1, 6, 1.5, -3, 3};
    for (std::size_t i = 0; i < std::size(results); ++i) {
        EXPECT_EQ(results[i].value(), expected[i]);
    }
    const bool expected_outcomes[] = {false, false, true, true, false, true};
    for (std::size_t i = 0; i < std::size(outcomes); ++i) {
        EXPECT_EQ(outcomes[i], expected_outcomes[i]);
    }
}

TEST(OperationCounts, CountVectorProductsAsSuchAndByTheirOperations)
{
    const Vector3<Counted> a = to_scalar<Counted>({1, 2, 3});
    const Vector3<Counted> b = to_scalar<Counted>({4, 5, 7});
    reset_operation_counts();
    EXPECT_EQ(dot(a, b).value(), 35);
    EXPECT_EQ(operation_counts(),
              (OperationCounts{.additions = 2, .multiplications = 3, .dot_products = 1}));
    reset_operation_counts();
    const Vector3<Counted> product = cross(a, b);
    EXPECT_EQ(operation_counts(),
              (OperationCounts{.subtractions = 3, .multiplications = 6, .cross_products = 1}));
    EXPECT_EQ(product.x().value(), -1);
    EXPECT_EQ(product.y().value(), 5);
    EXPECT_EQ(product.z().value(), -3);
}

TEST(OperationCounts, AreSeparateForEveryThread)
{
    reset_operation_counts();
    std::jthread([] {
        const Counted one = 1;
        EXPECT_EQ((one + one).value(), 2);
        EXPECT_EQ(operation_counts().additions, 1);
    }).join();
    EXPECT_EQ(operation_counts(), OperationCounts{});
}

} // namespace
} // namespace proxima::operation_counts_test
