// Times of ticks by what they were about, and what they asked for.
#pragma once

#include "touch_track.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima::bench {

/// Times of some ticks. Quantiles are exact: the least time that so large a part do not exceed.
class TickTimes {
public:
    void add(std::int64_t nanoseconds) { times_.push_back(nanoseconds); }
    [[nodiscard]] std::size_t count() const { return times_.size(); }
    [[nodiscard]] double microseconds(double part) const;

private:
    std::vector<std::int64_t> times_;
};

/// Ticks of one kind, times and work.
struct TickSum {
    TickTimes times;
    ContactWork work;
    void add(std::int64_t nanoseconds, const ContactWork& tick);
};

/// By state, and all together as the last one.
using TickSums = std::array<TickSum, tick_state_names.size() + 1>;

void add_track(TickSums& sums, const TouchTrack& track, const TrackTimes& times);

/// A tick that took long.
struct SlowTick {
    std::string script;
    std::size_t tick = 0;
    TickState state = TickState::free;
    std::int64_t least = 0; ///< ns
    std::int64_t first = 0; ///< in the first replay
    std::size_t moves = 0;
    ContactWork work;
};

/// The slowest ticks of all tracks by their least times, and all first times beside these.
class SlowTicks {
public:
    void add(const std::string& script, const TouchTrack& track, const TrackTimes& times);
    /// Quantiles of the first replay alone, then `count` ticks and what they did.
    void print(std::size_t count) const;

private:
    std::vector<SlowTick> ticks_;
};

/// `what` the rows are named by.
void print_head(const char* what);
/// A row for each state that there was. Without work for methods that do not count it.
void print_rows(const std::string& name, const TickSums& sums, bool with_work);

} // namespace proxima::bench
