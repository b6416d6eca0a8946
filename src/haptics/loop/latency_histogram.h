// How long things took, counted in bins of three per cent.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace proxima {

/// Nanoseconds, from 0 to 2^63. noexcept, no allocation; one thread.
class LatencyHistogram {
public:
    void add(std::int64_t nanoseconds) noexcept
    {
        const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(nanoseconds, 0));
        ++bins_[bin_of(value)];
        ++count_;
        max_ = std::max(max_, value);
    }

    /// Adds all that another one has counted.
    void add(const LatencyHistogram& other) noexcept
    {
        for (std::size_t bin = 0; bin < bins_.size(); ++bin) bins_[bin] += other.bins_[bin];
        count_ += other.count_;
        max_ = std::max(max_, other.max_);
    }

    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    [[nodiscard]] std::uint64_t max() const noexcept { return max_; } ///< exact

    /// How many are below a power of two, exactly.
    [[nodiscard]] std::uint64_t count_below(std::uint64_t power_of_two) const noexcept
    {
        std::uint64_t sum = 0;
        for (std::size_t bin = 0; bin < bin_of(power_of_two); ++bin) sum += bins_[bin];
        return sum;
    }

    /// The value that at least so large a part of all do not exceed, rounded up to its bin's end;
    /// 0 where there are none. \pre 0 <= part <= 1
    [[nodiscard]] std::uint64_t quantile(double part) const noexcept
    {
        if (count_ == 0) return 0;
        const double wanted = part * static_cast<double>(count_);
        std::uint64_t sum = 0;
        for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
            sum += bins_[bin];
            if (sum > 0 && static_cast<double>(sum) >= wanted) return std::min(last_of(bin), max_);
        }
        return max_;
    }

private:
    static constexpr unsigned fine_bits = 5; // 32 bins to a power of two

    [[nodiscard]] static std::size_t bin_of(std::uint64_t value) noexcept
    {
        if (value < 2U << fine_bits) return value;
        const auto shift = static_cast<unsigned>(std::bit_width(value)) - fine_bits - 1;
        return (std::size_t{shift} << fine_bits) + (value >> shift);
    }
    [[nodiscard]] static std::uint64_t last_of(std::size_t bin) noexcept
    {
        if (bin < 2U << fine_bits) return bin;
        const std::size_t shift = (bin >> fine_bits) - 1;
        const std::uint64_t leading = bin - (shift << fine_bits);
        return ((leading + 1) << shift) - 1;
    }

    std::array<std::uint64_t, std::size_t{65} << fine_bits> bins_{};
    std::uint64_t count_ = 0;
    std::uint64_t max_ = 0;
};

} // namespace proxima
