// The triangles that stand for a cell's features: all its faces, and one triangle of every edge and
// vertex that no face covers already.
#pragma once

#include "index/lists/local_features.h"

#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

/// A set of numbers that is emptied at no cost. Grows with use.
class RankSet {
public:
    /// Empty, with capacity for `count`.
    void clear(std::size_t count);

    /// False where it was there already. \pre fewer than `count` numbers so far
    bool insert(std::uint32_t rank) noexcept;

    [[nodiscard]] bool contains(std::uint32_t rank) const noexcept;

private:
    struct Slot {
        std::uint32_t rank = 0;
        std::uint32_t epoch = 0;
    };
    [[nodiscard]] std::size_t slot_of(std::uint32_t rank) const noexcept;

    std::vector<Slot> slots_;
    std::uint32_t epoch_ = 0;
    unsigned shift_ = 64;
};

/// Ranks of triangles that hold all the features, ascending, into `cover`. O(features log).
void cover_features(const LocalFeatures& features, std::span<const std::uint32_t> list,
                    RankSet& taken, std::vector<std::uint32_t>& cover);

} // namespace proxima
