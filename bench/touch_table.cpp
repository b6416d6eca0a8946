#include "touch_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace proxima::bench {

double TickTimes::microseconds(double part) const
{
    if (times_.empty()) return 0;
    std::vector<std::int64_t> sorted = times_;
    const double wanted = std::ceil(part * static_cast<double>(sorted.size()));
    const auto rank = static_cast<std::size_t>(std::max(wanted, 1.0)) - 1;
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(std::min(rank, sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    return 1e-3 * static_cast<double>(*at);
}

void TickSum::add(std::int64_t nanoseconds, const ContactWork& tick)
{
    times.add(nanoseconds);
    work.distances += tick.distances;
    work.gathers += tick.gathers;
    work.gathered += tick.gathered;
    work.scans += tick.scans;
    work.scanned += tick.scanned;
    work.passed += tick.passed;
}

void add_track(TickSums& sums, const TouchTrack& track, const TrackTimes& times)
{
    for (std::size_t tick = 0; tick < track.kinds.size(); ++tick) {
        const std::int64_t nanoseconds = times.nanoseconds[tick];
        sums[static_cast<std::size_t>(track.kinds[tick])].add(nanoseconds, track.work[tick]);
        sums.back().add(nanoseconds, track.work[tick]);
    }
}

void SlowTicks::add(const std::string& script, const TouchTrack& track, const TrackTimes& times)
{
    for (std::size_t tick = 0; tick < track.kinds.size(); ++tick) {
        ticks_.push_back({script, tick, track.kinds[tick], times.nanoseconds[tick],
                          times.first[tick], track.moves[tick], track.work[tick]});
    }
}

void SlowTicks::print(std::size_t count) const
{
    TickTimes first;
    for (const SlowTick& tick : ticks_) first.add(tick.first);
    std::printf("%-15s %-8s %8zu  %8.2f %8.2f %8.2f %8.2f  one replay, with what else the machine "
                "did\n",
                "raw", "all", first.count(), first.microseconds(0.5), first.microseconds(0.99),
                first.microseconds(0.9999), first.microseconds(1));
    if (count == 0) return;
    std::vector<SlowTick> slowest = ticks_;
    std::ranges::stable_sort(slowest, std::ranges::greater(), &SlowTick::least);
    slowest.resize(std::min(count, slowest.size()));
    std::printf("%-15s %-8s %8s  %8s %8s %8s %8s  %8s %8s %8s\n", "slowest", "state", "tick",
                "least us", "raw us", "moves", "queries", "scans", "lanes", "in full");
    for (const SlowTick& slow : slowest) {
        const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
        std::printf(
            "%-15s %-8s %8zu  %8.2f %8.2f %8zu %8llu  %8llu %8llu %8llu\n", slow.script.c_str(),
            std::string(tick_state_names[static_cast<std::size_t>(slow.state)]).c_str(), slow.tick,
            1e-3 * static_cast<double>(slow.least), 1e-3 * static_cast<double>(slow.first),
            slow.moves, number(slow.work.distances + slow.work.gathers), number(slow.work.scans),
            number(slow.work.scanned), number(slow.work.passed));
    }
}

void print_head(const char* what)
{
    std::printf("%-15s %-8s %8s  %8s %8s %8s %8s  %8s %8s %8s %8s %8s\n", what, "state", "ticks",
                "p50 us", "p99", "p99.99", "max", "queries", "gathered", "scans", "lanes",
                "in full");
}

void print_rows(const std::string& name, const TickSums& sums, bool with_work)
{
    for (std::size_t state = 0; state < sums.size(); ++state) {
        const TickSum& sum = sums[state];
        if (sum.times.count() == 0) continue;
        const std::string state_name(state < tick_state_names.size() ? tick_state_names[state]
                                                                     : "all");
        std::printf("%-15s %-8s %8zu  %8.2f %8.2f %8.2f %8.2f", name.c_str(), state_name.c_str(),
                    sum.times.count(), sum.times.microseconds(0.5), sum.times.microseconds(0.99),
                    sum.times.microseconds(0.9999), sum.times.microseconds(1));
        if (with_work) {
            const auto per_tick = [&](std::uint64_t number) {
                return static_cast<double>(number) / static_cast<double>(sum.times.count());
            };
            std::printf("  %8.3f %8.2f %8.2f %8.1f %8.2f",
                        per_tick(sum.work.distances + sum.work.gathers),
                        per_tick(sum.work.gathered), per_tick(sum.work.scans),
                        per_tick(sum.work.scanned), per_tick(sum.work.passed));
        }
        std::printf("\n");
    }
}

} // namespace proxima::bench
