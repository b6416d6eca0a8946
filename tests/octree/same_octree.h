// Equality of octrees' arrays, with words for what differs.
#pragma once

#include "proxima/octree.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace proxima::testing {

/// The same nodes and references, bit for bit.
inline ::testing::AssertionResult same_arrays(const Octree& a, const Octree& b)
{
    if (!std::ranges::equal(a.nodes(), b.nodes())) {
        return ::testing::AssertionFailure() << "nodes differ";
    }
    if (!std::ranges::equal(a.references(), b.references())) {
        return ::testing::AssertionFailure() << "references differ";
    }
    return ::testing::AssertionSuccess();
}

} // namespace proxima::testing
