// Numbers of the few items of a mesh that a message has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace proxima {

/// Numbers from 0 on, in the order in which they are asked for.
class LocalNumbers {
public:
    explicit LocalNumbers(std::size_t count) : numbers_(count, none) {}

    /// Throws std::bad_alloc.
    std::uint32_t number_of(std::uint32_t item)
    {
        if (numbers_[item] == none) {
            numbers_[item] = static_cast<std::uint32_t>(used_.size());
            used_.push_back(item);
        }
        return numbers_[item];
    }
    /// Items by number; forgets them.
    std::vector<std::uint32_t> take()
    {
        for (const std::uint32_t item : used_) numbers_[item] = none;
        return std::exchange(used_, {});
    }

private:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> numbers_;
    std::vector<std::uint32_t> used_;
};

} // namespace proxima
