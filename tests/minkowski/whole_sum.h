// Sums of polyhedra of whole coordinates, told exactly: integer vectors, facets by their normals.
#pragma once

#include "proxima/minkowski_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

namespace proxima::test {

using Whole = std::array<std::int64_t, 3>;

inline Whole whole(const Vec3& v)
{
    return {static_cast<std::int64_t>(v.x()), static_cast<std::int64_t>(v.y()),
            static_cast<std::int64_t>(v.z())};
}
inline Whole operator-(const Whole& a, const Whole& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Whole cross(const Whole& a, const Whole& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline std::int64_t dot(const Whole& a, const Whole& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Whole reduced(Whole n)
{
    const std::int64_t divisor = std::gcd(std::gcd(n[0], n[1]), n[2]);
    if (divisor != 0) {
        for (auto& c : n) c /= divisor;
    }
    return n;
}
inline bool is_zero(const Whole& n)
{
    return n == Whole{0, 0, 0};
}

inline Whole exact_normal(const MinkowskiSum& sum, std::uint32_t facet)
{
    const auto factors = sum.normal_factors(facet);
    return reduced(cross(whole(factors.u.rounded()), whole(factors.v.rounded())));
}

inline void expect_euler(const MinkowskiSum& sum)
{
    for (const SumEdge& edge : sum.edges()) {
        EXPECT_NE(edge.left, no_facet);
        EXPECT_NE(edge.right, no_facet);
        EXPECT_NE(edge.left, edge.right);
    }
    if (sum.is_bounded()) {
        EXPECT_EQ(static_cast<int>(sum.vertex_count()) - static_cast<int>(sum.edges().size()) +
                      static_cast<int>(sum.facet_count()),
                  2);
    }
}

/// Facets by normal: offset, corners as pairs, origin.
struct Described {
    std::int64_t offset = 0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> corners;
    FacetOrigin origin = FacetOrigin::a;
    friend bool operator==(const Described&, const Described&) = default;
};

inline std::map<Whole, Described> described(const MinkowskiSum& sum)
{
    std::map<Whole, Described> result;
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
        const Whole n = exact_normal(sum, f);
        Described facet;
        for (const std::uint32_t v : sum.facet_loop(f)) {
            facet.corners.emplace_back(sum.corner(v).a, sum.corner(v).b);
        }
        // Loops are the same up to where they start.
        std::rotate(facet.corners.begin(), std::ranges::min_element(facet.corners),
                    facet.corners.end());
        facet.offset = dot(whole(sum.position(sum.facet_loop(f)[0])), n);
        facet.origin = sum.facet(f).origin;
        EXPECT_TRUE(result.emplace(n, facet).second);
    }
    return result;
}

} // namespace proxima::test
