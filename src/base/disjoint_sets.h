// Which of many numbered things belong together.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
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
        if (parent_[a] == parent_[b]) return; // most pairs, where many say the same
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// Numbers of which only differences are known: union-find that keeps them.
class DisjointOffsets {
public:
    /// One number of a set, told from its smallest member's.
    struct Offset {
        std::uint32_t smallest = 0;
        std::int64_t difference = 0; ///< this member's number less the smallest member's
    };

    explicit DisjointOffsets(std::size_t count) : parent_(count), above_parent_(count)
    {
        std::iota(parent_.begin(), parent_.end(), 0U);
    }

    /// Shortens paths, so not for several threads.
    [[nodiscard]] Offset find(std::uint32_t member) noexcept
    {
        Offset found{member, 0};
        while (parent_[found.smallest] != found.smallest) {
            found.difference += above_parent_[found.smallest];
            found.smallest = parent_[found.smallest];
        }
        for (std::int64_t left = found.difference; member != found.smallest;) {
            const std::uint32_t next = std::exchange(parent_[member], found.smallest);
            left -= std::exchange(above_parent_[member], left);
            member = next;
        }
        return found;
    }

    /// The number of `b` is that of `a` plus `difference`. Says nothing new where both are in one
    /// set already.
    void unite(std::uint32_t a, std::uint32_t b, std::int64_t difference) noexcept
    {
        const Offset of_a = find(a);
        const Offset of_b = find(b);
        const std::int64_t between = of_a.difference + difference - of_b.difference;
        if (of_a.smallest < of_b.smallest) {
            parent_[of_b.smallest] = of_a.smallest;
            above_parent_[of_b.smallest] = between;
        } else if (of_b.smallest < of_a.smallest) {
            parent_[of_a.smallest] = of_b.smallest;
            above_parent_[of_a.smallest] = -between;
        }
    }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<std::int64_t> above_parent_; ///< number less the parent's
};

} // namespace proxima
