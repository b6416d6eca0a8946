#include "haptics/force/fast_oscillations.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace proxima {

namespace {

constexpr double least_leg = 3e-4; ///< m: six steps of the coarsest encoder
constexpr int most_ticks = 6;
constexpr double least_growth = 0.01;

} // namespace

/// Ends a leg, and judges the legs so far.
double FastOscillations::turn() noexcept
{
    const double length = (farthest_ - turned_).norm();
    if (length < least_leg || ticks_ > most_ticks) {
        count_ = 0;
        return 0;
    }
    lengths_[count_ % legs] = length;
    ++count_;
    if (count_ % legs != 0) return 0;
    const std::span<const double> all = lengths_;
    const double grown =
        std::log(std::ranges::max(all.last(legs / 2)) / std::ranges::max(all.first(legs / 2)));
    return grown >= 0 ? std::max(grown, least_growth) : 0;
}

double FastOscillations::watch(const Vec3& position) noexcept
{
    if (!placed_) {
        placed_ = true;
        turned_ = farthest_ = position;
        return 0;
    }
    if ((position - farthest_).dot(farthest_ - turned_) >= 0) {
        farthest_ = position;
        ++ticks_;
        return 0;
    }
    const double proven = turn();
    turned_ = farthest_;
    farthest_ = position;
    ticks_ = 1;
    return proven;
}

} // namespace proxima
