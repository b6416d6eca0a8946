// Which of many numbered things belong together.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace proxima {

/// Union-find. A set's representative is its smallest member, so it does not depend on the order
/// of unions.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) : parent_(count)
    {
        std::iota(parent_.begin(), parent_.end(), 0U);
    }

    /// Smallest member of the set of `member`. Shortens paths, so not for several threads.
    [[nodiscard]] std::uint32_t find(std::uint32_t member) noexcept
    {
        while (parent_[member] != member) {
            parent_[member] = parent_[parent_[member]];
            member = parent_[member];
        }
        return member;
    }

    void unite(std::uint32_t a, std::uint32_t b) noexcept
    {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

} // namespace proxima
