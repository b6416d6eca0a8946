// What fuzzers hold answers against: slow ones, and every part of them.
#pragma once

#include "base/check.h"
#include "proxima/closest_feature.h"
#include "proxima/intersect_meshes.h"
#include "query/contact/self_intersection.h"

#include <cstdint>
#include <vector>

namespace proxima::fuzz {

inline void expect_same(const ClosestFeature& found, const ClosestFeature& truth)
{
    PROXIMA_CHECK(found.feature == truth.feature);
    PROXIMA_CHECK(found.triangle == truth.triangle);
    PROXIMA_CHECK(found.point == truth.point);
    PROXIMA_CHECK(found.barycentric == truth.barycentric);
    PROXIMA_CHECK(found.squared_distance == truth.squared_distance);
}

/// Self-intersections by a test of all pairs.
inline std::vector<TrianglePair> self_intersections(const TriangleMesh& mesh)
{
    std::vector<TrianglePair> pairs;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        for (std::uint32_t j = i + 1; j < mesh.triangle_count(); ++j) {
            if (meet_beyond_corners(triangle, mesh.triangle(TriangleId{j})))
                pairs.push_back({TriangleId{i}, TriangleId{j}});
        }
    }
    return pairs;
}

} // namespace proxima::fuzz
