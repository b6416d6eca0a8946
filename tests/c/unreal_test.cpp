// examples/unreal/ProximaIndex.h, with stand-ins for Unreal's types: that it compiles, and what it answers.
#include "unreal/ProximaIndex.h"

#include <cmath>
#include <gtest/gtest.h>

namespace {

const TArray<FVector> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const TArray<int32> triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

TEST(ForUnreal, AnswersForATetrahedron)
{
    const FProximaIndex index(corners, triangles);
    ASSERT_TRUE(index.IsValid());
    EXPECT_NEAR(index.SignedDistance({0.2, 0.2, 0.1}), -0.1, 1e-15);
    EXPECT_NEAR(index.SignedDistance({0.2, 0.2, -2}), 2, 1e-15);
    FVector point;
    int32 triangle = -1;
    ASSERT_TRUE(index.ClosestPoint({0.2, 0.3, -2}, point, triangle));
    EXPECT_EQ(triangle, 0);
    EXPECT_EQ(point.Y, 0.3);
    EXPECT_FALSE(index.ClosestPoint({0.2, 0.3, -2}, point, triangle, 1.9));
    EXPECT_FALSE(index.ClosestPoint({std::nan(""), 0, 0}, point, triangle));
    double fraction = 0;
    ASSERT_TRUE(index.LineTrace({0.2, 0.2, -1}, {0.2, 0.2, 3}, fraction, triangle));
    EXPECT_EQ(fraction, 0.25);
    EXPECT_EQ(triangle, 0);
    EXPECT_FALSE(index.LineTrace({0.2, 0.2, -1}, {0.2, 0.2, -0.1}, fraction, triangle));
}

TEST(ForUnreal, SaysWhatIsWrong)
{
    const FProximaIndex wrong(corners, {0, 1, 9});
    EXPECT_FALSE(wrong.IsValid());
    EXPECT_FALSE(wrong.Error().IsEmpty());
    const FProximaIndex part(corners, {0, 1, 2, 3});
    EXPECT_FALSE(part.IsValid());
    EXPECT_FALSE(part.Error().IsEmpty());
    const FProximaIndex empty({}, {});
    EXPECT_FALSE(empty.IsValid());
    EXPECT_FALSE(empty.Error().IsEmpty());
    const FProximaIndex without(corners, triangles, 0);
    EXPECT_TRUE(std::isnan(without.SignedDistance({0, 0, 0})));
}

} // namespace
