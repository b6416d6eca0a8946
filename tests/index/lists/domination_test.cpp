// What dominates a feature is found whatever the length of the list.
#include "index/lists/domination.h"

#include <gtest/gtest.h>
#include <vector>

namespace proxima::domination_test {
namespace {

/// Features that are points.
LocalFeatures features_at(const std::vector<Eigen::Vector3f>& points)
{
    LocalFeatures all;
    for (const Eigen::Vector3f& point : points) {
        LocalFeature feature;
        feature.kind = FeatureKind::vertex;
        feature.numbers = static_cast<std::uint32_t>(all.numbers.size());
        feature.incident_count = 1;
        all.numbers.insert(all.numbers.end(), point.begin(), point.end());
        all.incident.push_back(0);
        all.features.push_back(feature);
    }
    return all;
}

TEST(Domination, KnowsPositionsThatFloatsCannotHold)
{
    const LocalFeatures features = features_at({{-9, 0, 0}, {3, 0, 0}, {0, 0, 0}});
    const FrameCell cell{{0, 0, 0}, 0.5F};
    // The near one is at a position that floats round up to the list's end, and there is one that is
    // no part of the list and nearer.
    constexpr std::size_t count = (std::size_t{1} << 24U) + 4;
    std::vector<std::uint32_t> list(count + 1, 0);
    list[count - 1] = 1;
    list[count] = 2;
    DominationScratch scratch;
    ASSERT_EQ(drop_dominated(features, list.data(), count, cell, scratch), 1U);
    EXPECT_EQ(list[0], 1U);
}

} // namespace
} // namespace proxima::domination_test
