// Numbers of the few items of a mesh that a message has.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// A set of items, numbered from 0 on in ascending order: a bit for each item, a number for the first
/// of each word of bits, and a bit for each word that has items.
class LocalNumbers {
public:
    /// An empty set, for items below `count`. Throws std::bad_alloc.
    explicit LocalNumbers(std::size_t count)
        : words_((count + 63) / 64), numbers_(words_.size()), used_((words_.size() + 63) / 64)
    {}

    void add(std::uint32_t item) noexcept
    {
        words_[item / 64] |= std::uint64_t{1} << item % 64;
        used_[item / 4096] |= std::uint64_t{1} << item / 64 % 64;
    }

    /// Numbers what was added so far, and returns how many that is.
    std::uint32_t number() noexcept
    {
        std::uint32_t count = 0;
        each_word([&](std::size_t word) {
            numbers_[word] = count;
            count += static_cast<std::uint32_t>(std::popcount(words_[word]));
        });
        return count;
    }

    /// Calls visit(item), ascending.
    template <class Visit>
    void each(const Visit& visit) const
    {
        each_word([&](std::size_t word) { each_bit(words_[word], 64 * word, visit); });
    }

    /// \pre the item is in the set, and nothing was added since number()
    [[nodiscard]] std::uint32_t number_of(std::uint32_t item) const noexcept
    {
        const std::uint64_t below = (std::uint64_t{1} << item % 64) - 1;
        return numbers_[item / 64] +
               static_cast<std::uint32_t>(std::popcount(words_[item / 64] & below));
    }

    void clear() noexcept
    {
        each_word([&](std::size_t word) { words_[word] = 0; });
        for (std::uint64_t& word : used_) word = 0;
    }

private:
    template <class Visit>
    static void each_bit(std::uint64_t bits, std::size_t first, const Visit& visit)
    {
        for (; bits != 0; bits &= bits - 1) {
            visit(static_cast<std::uint32_t>(first) +
                  static_cast<std::uint32_t>(std::countr_zero(bits)));
        }
    }

    template <class Visit>
    void each_word(const Visit& visit) const
    {
        for (std::size_t i = 0; i < used_.size(); ++i) each_bit(used_[i], 64 * i, visit);
    }

    std::vector<std::uint64_t> words_;
    std::vector<std::uint32_t> numbers_; ///< of the first item of each word
    std::vector<std::uint64_t> used_;    ///< bit i % 64 of word i / 64: words_[i] has items
};

} // namespace proxima
