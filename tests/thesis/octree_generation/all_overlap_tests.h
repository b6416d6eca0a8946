// The thesis's four overlap tests as types for typed tests.
#pragma once

#include "thesis/octree_generation/overlap_index_tracking.h"
#include "thesis/octree_generation/overlap_minkowski.h"
#include "thesis/octree_generation/overlap_pairwise.h"
#include "thesis/octree_generation/overlap_separating_axis.h"

#include <gtest/gtest.h>
#include <string>
#include <type_traits>

namespace proxima::testing {

struct OverlapTestNames {
    template <class Test>
    static std::string GetName(int /*index*/) // NOLINT(readability-identifier-naming): gtest's name
    {
        if (std::is_same_v<Test, PairwiseTest>) return "Pairwise";
        if (std::is_same_v<Test, SeparatingAxisTest>) return "SeparatingAxis";
        if (std::is_same_v<Test, MinkowskiTest>) return "Minkowski";
        return "IndexTracking";
    }
};

using AllOverlapTests =
    ::testing::Types<PairwiseTest, SeparatingAxisTest, MinkowskiTest, IndexTrackingTest>;

} // namespace proxima::testing
