#include "proxima/device.h"

#include <algorithm>
#include <bit>

namespace proxima {

namespace {

std::size_t bin_of(std::uint64_t value, unsigned fine_bits) noexcept
{
    if (value < 2U << fine_bits) return value;
    const auto shift = static_cast<unsigned>(std::bit_width(value)) - fine_bits - 1;
    return (std::size_t{shift} << fine_bits) + (value >> shift);
}

std::uint64_t last_of(std::size_t bin, unsigned fine_bits) noexcept
{
    if (bin < 2U << fine_bits) return bin;
    const std::size_t shift = (bin >> fine_bits) - 1;
    const std::uint64_t leading = bin - (shift << fine_bits);
    return ((leading + 1) << shift) - 1;
}

} // namespace

void LatencyHistogram::add(std::int64_t nanoseconds) noexcept
{
    const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(nanoseconds, 0));
    ++bins_[bin_of(value, fine_bits)];
    ++count_;
    max_ = std::max(max_, value);
}

void LatencyHistogram::add(const LatencyHistogram& other) noexcept
{
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) bins_[bin] += other.bins_[bin];
    count_ += other.count_;
    max_ = std::max(max_, other.max_);
}

std::uint64_t LatencyHistogram::count_below(std::uint64_t power_of_two) const noexcept
{
    std::uint64_t sum = 0;
    for (std::size_t bin = 0; bin < bin_of(power_of_two, fine_bits); ++bin) sum += bins_[bin];
    return sum;
}

std::uint64_t LatencyHistogram::quantile(double part) const noexcept
{
    if (count_ == 0) return 0;
    const double wanted = part * static_cast<double>(count_);
    std::uint64_t sum = 0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
        sum += bins_[bin];
        if (sum > 0 && static_cast<double>(sum) >= wanted)
            return std::min(last_of(bin, fine_bits), max_);
    }
    return max_;
}

} // namespace proxima
