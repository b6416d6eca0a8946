// Bits that several threads may set at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// All are clear at first. Orders nothing: what threads tell each other by it needs a hand-over of
/// its own, as the end of a parallel loop is one.
class AtomicBits {
public:
    explicit AtomicBits(std::size_t count) : words_((count + 63) / 64) {}

    /// Sets the bit; whether it was set before. \pre i is below the count
    bool set(std::size_t i) noexcept
    {
        const std::uint64_t bit = std::uint64_t{1} << i % 64;
        return (words_[i / 64].fetch_or(bit, std::memory_order_relaxed) & bit) != 0;
    }

private:
    std::vector<std::atomic<std::uint64_t>> words_;
};

} // namespace proxima
