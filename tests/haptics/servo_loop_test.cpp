#include "proxima/device.h"

#include "counted_allocations.h"
#include "haptics/loop/tick_account.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <pthread.h>
#include <random>
#include <sched.h>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <thread>
#include <vector>

namespace proxima::servo_loop_test {
namespace {

TEST(LatencyHistogram, QuantilesAreWithinThreePercent)
{
    std::mt19937_64 random(1);
    LatencyHistogram histogram;
    EXPECT_EQ(histogram.quantile(0.5), 0U);
    std::vector<std::uint64_t> values;
    for (int i = 0; i < 20000; ++i) {
        values.push_back(random() >> (random() % 60 + 1));
        histogram.add(static_cast<std::int64_t>(values.back()));
    }
    std::ranges::sort(values);
    for (const double part : {0.0, 0.001, 0.25, 0.5, 0.9, 0.99, 0.9999, 1.0}) {
        const auto rank = static_cast<std::size_t>(std::ceil(part * 20000));
        const auto exact = static_cast<double>(values[rank == 0 ? 0 : rank - 1]);
        const auto said = static_cast<double>(histogram.quantile(part));
        EXPECT_GE(said, exact) << part;
        EXPECT_LE(said, exact * 33 / 32 + 1) << part;
    }
    EXPECT_EQ(histogram.max(), values.back());
    EXPECT_EQ(histogram.count(), 20000U);
    histogram.add(-5);
    EXPECT_EQ(histogram.quantile(0), 0U);
}

TEST(LatencyHistogram, AddsUpAndCountsWhatIsBelowPowersOfTwo)
{
    LatencyHistogram some;
    LatencyHistogram others;
    LatencyHistogram all;
    for (int i = 0; i < 2000; ++i) {
        (i % 3 == 0 ? some : others).add(i * 37);
        all.add(i * 37);
    }
    others.add(some);
    EXPECT_EQ(others.count(), 2000U);
    EXPECT_EQ(others.max(), all.max());
    for (const double part : {0.0, 0.1, 0.5, 0.9, 1.0})
        EXPECT_EQ(others.quantile(part), all.quantile(part)) << part;
    LatencyHistogram ends;
    for (const int value : {255, 256, 257}) ends.add(value);
    EXPECT_EQ(ends.count_below(256), 1U);
    EXPECT_EQ(ends.count_below(512), 3U);
}

TEST(LatencyHistogram, ASumHasTheGreatestOfBoth)
{
    LatencyHistogram small;
    LatencyHistogram large;
    small.add(1000);
    large.add(5000); // in a bin from 4992 to 5119
    small.add(large);
    EXPECT_EQ(small.max(), 5000U);
    EXPECT_EQ(small.quantile(1), 5000U);
}

TEST(ServoLoop, KeepsItsRate)
{
    using Clock = std::chrono::steady_clock;
    std::vector<Clock::time_point> times(200);
    const ServoStatistics seen = run_servo_loop({.rate = 1000, .ticks = 200}, [&](std::uint64_t i) {
        times[i] = Clock::now();
        return Flow::proceed;
    });
    EXPECT_EQ(seen.ticks, 200U);
    EXPECT_EQ(seen.late.count(), 200U);
    const auto planned = std::chrono::microseconds(1000);
    // No tick comes before its time, however late others were.
    for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_GE(times[i] - times[0] + std::chrono::milliseconds(1), i * planned) << i;
    EXPECT_GE(seen.seconds, 0.198);
    // Nor later than it says.
    const double last = 1e-3 * static_cast<double>(199 + seen.skipped);
    EXPECT_LE(seen.seconds,
              last + 1e-9 * static_cast<double>(seen.late.max() + seen.work.max()) + 1e-6);
}

TEST(ServoLoop, CountsMissedTicksWithoutCatchingUp)
{
    const ServoStatistics seen = run_servo_loop({.rate = 1000, .ticks = 30}, [](std::uint64_t i) {
        if (i == 10) std::this_thread::sleep_for(std::chrono::microseconds(5500));
        return Flow::proceed;
    });
    EXPECT_GE(seen.missed, 1U);
    EXPECT_GE(seen.skipped, 4U);
    EXPECT_GE(seen.seconds, 0.0325); // tick 29 is planned at 29 + 4 ms
    EXPECT_GE(seen.work.max(), 5'500'000U);
    // No tick begins before its planned time, which comes later by those that were left out.
    EXPECT_LE(1e-3 * static_cast<double>(29 + seen.skipped), seen.seconds + 1e-9);
}

TEST(ServoLoop, CountsATickThatEndsLateByLessThanAPeriod)
{
    const ServoStatistics seen = run_servo_loop({.rate = 10, .ticks = 4}, [](std::uint64_t i) {
        if (i == 1) std::this_thread::sleep_for(std::chrono::milliseconds(150));
        return Flow::proceed;
    });
    EXPECT_GE(seen.missed, 1U);
    // It began in time, unless the machine is so busy that a tick begins a whole period late.
    EXPECT_TRUE(seen.overslept == 0 || seen.late.max() >= 100'000'000U) << seen.overslept;
}

TEST(TickAccount, CountsWhatTheDriverLeftOut)
{
    const auto proceed = [](std::uint64_t) { return Flow::proceed; };
    TickAccount in_time({.rate = 0.1}, proceed);
    for (int i = 0; i < 3; ++i) (void)in_time.tick();
    EXPECT_EQ(in_time.finish().missed, 0U);
    EXPECT_EQ(in_time.finish().skipped, 0U);

    constexpr double period = 1e7; // ns
    TickAccount late({.rate = 100}, proceed);
    (void)late.tick();
    std::this_thread::sleep_for(std::chrono::milliseconds(34));
    (void)late.tick();
    const ServoStatistics seen = late.finish();
    const double interval = static_cast<double>(seen.late.max()) + period;
    EXPECT_EQ(seen.missed, 1U);
    EXPECT_GE(seen.skipped, 2U);
    EXPECT_NEAR(static_cast<double>(seen.skipped + 1), interval / period, 0.5 + 1e-6);
}

TEST(ServoLoop, StopsOnRequestAndDoesNotAllocate)
{
    std::size_t first = 0;
    std::size_t last = 0;
    const ServoStatistics seen =
        run_servo_loop({.ticks = 1000, .pace = Pace::unpaced}, [&](std::uint64_t i) {
            if (i == 0) first = testing::allocation_count();
            last = testing::allocation_count();
            return i == 99 ? Flow::stop : Flow::proceed;
        });
    EXPECT_EQ(seen.ticks, 100U);
    EXPECT_EQ(first, last);
    EXPECT_EQ(seen.missed, 0U);
}

TEST(ServoLoop, ReportsWhatTheSystemDidNotGrant)
{
    const ServoStatistics seen = run_servo_loop({.ticks = 3, .pace = Pace::real_time},
                                                [](std::uint64_t) { return Flow::proceed; });
    EXPECT_EQ(seen.real_time_priority && seen.locked_memory, seen.note.empty()) << seen.note;
}

TEST(ServoLoop, LeavesTheThreadAsItWas)
{
    int before = 0;
    int within = 0;
    int after = 0;
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &before, &parameters);
    const int priority_before = parameters.sched_priority;
    const ServoStatistics seen =
        run_servo_loop({.ticks = 1, .pace = Pace::real_time}, [&](std::uint64_t) {
            pthread_getschedparam(pthread_self(), &within, &parameters);
            return Flow::proceed;
        });
    if (!seen.real_time_priority) GTEST_SKIP() << seen.note;
    EXPECT_EQ(within, SCHED_FIFO);
    pthread_getschedparam(pthread_self(), &after, &parameters);
    EXPECT_EQ(after, before);
    EXPECT_EQ(parameters.sched_priority, priority_before);
}

TEST(ServoLoop, CountsWhatItOverslept)
{
    // A sleep of about a microsecond takes some fifty. In nanoseconds a period is a power of two, so that
    // the histogram counts those exactly that woke up after their deadline.
    constexpr std::uint64_t period = 1024;
    const ServoStatistics seen = run_servo_loop({.rate = 1e9 / period, .ticks = 2000},
                                                [](std::uint64_t) { return Flow::proceed; });
    EXPECT_GT(seen.overslept, 0U);
    EXPECT_EQ(seen.overslept, seen.late.count() - seen.late.count_below(period));
    EXPECT_LE(seen.overslept, seen.missed);
}

/// Page faults of this thread so far, where the system tells.
std::uint64_t page_faults()
{
    rusage usage{};
#ifdef RUSAGE_THREAD
    getrusage(RUSAGE_THREAD, &usage);
#endif
    return static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt);
}

TEST(ServoLoop, CountsThePageFaultsOfItsTicks)
{
    constexpr std::size_t bytes = 1U << 20U;
    std::uint64_t faults = 0;
    const ServoStatistics seen =
        run_servo_loop({.ticks = 1, .pace = Pace::unpaced}, [&](std::uint64_t) {
            const std::uint64_t before = page_faults();
            void* const fresh =
                mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
            if (fresh == MAP_FAILED) return Flow::stop;
            std::memset(fresh, 1, bytes);
            munmap(fresh, bytes);
            faults = page_faults() - before;
            return Flow::proceed;
        });
    if (faults == 0) GTEST_SKIP() << "this system does not count the page faults of a thread";
    EXPECT_GE(seen.page_faults, faults);
}

/// Locked memory of this process in kB, as the system tells.
long locked_memory()
{
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmLck:")) return std::stol(line.substr(6));
    return 0;
}

TEST(ServoLoop, MemoryStaysLockedUntilTheLastLoopEnds)
{
    const ServoOptions once = {.ticks = 1, .pace = Pace::real_time};
    long alone = 0;
    long after_another = 0;
    const ServoStatistics seen = run_servo_loop(once, [&](std::uint64_t) {
        alone = locked_memory();
        std::thread([&] {
            (void)run_servo_loop(once, [](std::uint64_t) { return Flow::proceed; });
        }).join();
        after_another = locked_memory();
        return Flow::proceed;
    });
    if (!seen.locked_memory || alone == 0)
        GTEST_SKIP() << "this program may not lock memory: " << seen.note;
    EXPECT_GT(after_another, 0);
    EXPECT_EQ(locked_memory(), 0);
}

} // namespace
} // namespace proxima::servo_loop_test
