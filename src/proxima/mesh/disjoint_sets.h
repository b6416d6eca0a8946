// Disjoint sets of numbers that grow together (union-find); a set's root is its lowest number.
#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace proxima {

/// Starts with every number of [0, count) alone. Both operations take amortised O(log count).
class DisjointSets {
public:
    explicit DisjointSets(std::uint32_t count) : parents_(count)
    {
        std::iota(parents_.begin(), parents_.end(), 0U);
    }

    /// The lowest number of the item's set.
    [[nodiscard]] std::uint32_t root(std::uint32_t item) noexcept
    {
        while (parents_[item] != item) {
            parents_[item] = parents_[parents_[item]];
            item = parents_[item];
        }
        return item;
    }

    void unite(std::uint32_t a, std::uint32_t b) noexcept
    {
        auto [low, high] = std::pair(root(a), root(b));
        if (low > high) std::swap(low, high);
        parents_[high] = low;
    }

private:
    std::vector<std::uint32_t> parents_;
};

} // namespace proxima
