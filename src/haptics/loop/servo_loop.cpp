#include "base/check.h"
#include "base/text.h"
#include "haptics/loop/tick_account.h"
#include "proxima/device.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <mutex>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

namespace proxima {

namespace {

constexpr std::int64_t nanoseconds_per_second = 1'000'000'000;

std::int64_t now() noexcept
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * nanoseconds_per_second + time.tv_nsec;
}

void sleep_until(std::int64_t nanoseconds) noexcept
{
    const timespec time = {nanoseconds / nanoseconds_per_second,
                           nanoseconds % nanoseconds_per_second};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
    }
}

std::uint64_t page_faults_so_far() noexcept
{
#ifdef RUSAGE_THREAD
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return static_cast<std::uint64_t>(usage.ru_minflt) +
           static_cast<std::uint64_t>(usage.ru_majflt);
#else
    return 0;
#endif
}

/// Loops that have locked the memory of this process, which the last of them unlocks.
int locking_loops = 0;
std::mutex locking_mutex;

bool lock_memory()
{
    const std::lock_guard lock(locking_mutex);
    if (mlockall(MCL_CURRENT) != 0) return false;
    ++locking_loops;
    return true;
}

void unlock_memory()
{
    const std::lock_guard lock(locking_mutex);
    if (--locking_loops == 0) munlockall();
}

/// Real-time priority and locked memory while it lives, as far as they are granted.
class RealTimeGrant {
public:
    RealTimeGrant(Pace pace, ServoStatistics& statistics) : statistics_(statistics)
    {
        if (pace != Pace::real_time) return;
        pthread_getschedparam(pthread_self(), &policy_, &parameters_);
        sched_param wanted{};
        wanted.sched_priority = sched_get_priority_max(SCHED_FIFO) / 2;
        const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
        statistics.real_time_priority = refused == 0;
        if (refused != 0) {
            statistics.note += concat("no real-time priority (", std::strerror(refused),
                                      "): give the program CAP_SYS_NICE or an rtprio limit. ");
        }
        statistics.locked_memory = lock_memory();
        if (!statistics.locked_memory) {
            statistics.note += concat("memory is not locked (", std::strerror(errno),
                                      "): raise the memlock limit. ");
        }
        if (!statistics.note.empty()) statistics.note.pop_back();
    }
    RealTimeGrant(const RealTimeGrant&) = delete;
    RealTimeGrant& operator=(const RealTimeGrant&) = delete;
    ~RealTimeGrant()
    {
        if (statistics_.locked_memory) unlock_memory();
        if (statistics_.real_time_priority)
            pthread_setschedparam(pthread_self(), policy_, &parameters_);
    }

private:
    ServoStatistics& statistics_;
    int policy_ = SCHED_OTHER;
    sched_param parameters_{};
};

/// The number of ticks of a loop that only a tick ends.
constexpr std::uint64_t endless = std::numeric_limits<std::uint64_t>::max();

} // namespace

ServoStatistics run_servo_loop(const ServoOptions& options, ServoTick tick)
{
    PROXIMA_CHECK_GT(options.rate, 0);
    ServoStatistics seen;
    const RealTimeGrant grant(options.pace, seen);
    const double period = static_cast<double>(nanoseconds_per_second) / options.rate;
    const bool paced = options.pace != Pace::unpaced;
    const std::uint64_t faults_before = page_faults_so_far();
    const std::int64_t begin = now();
    double planned = 0; // ticks since the beginning
    std::int64_t end = begin;
    const std::uint64_t count = options.ticks.value_or(endless);
    for (std::uint64_t number = 0; number < count; ++number) {
        std::int64_t start = now();
        if (paced) {
            const std::int64_t at = begin + std::llround(planned * period);
            if (start < at) {
                sleep_until(at);
                start = now();
            }
            seen.late.add(start - at);
        }
        const Flow flow = tick(number);
        end = now();
        seen.work.add(end - start);
        ++seen.ticks;
        if (flow == Flow::stop) break;
        planned += 1;
        if (!paced) continue;
        const double passed = std::floor(static_cast<double>(end - begin) / period);
        if (passed < planned) continue;
        ++seen.missed;
        if (static_cast<double>(start - begin) >= planned * period) ++seen.overslept;
        seen.skipped += static_cast<std::uint64_t>(passed - planned);
        planned = std::max(planned, passed);
    }
    seen.page_faults = page_faults_so_far() - faults_before;
    seen.seconds = static_cast<double>(end - begin) / static_cast<double>(nanoseconds_per_second);
    return seen;
}

TickAccount::TickAccount(const ServoOptions& options, ServoTick called) noexcept
    : options_(options), tick_(called)
{
    PROXIMA_CHECK_GT(options.rate, 0);
}

Flow TickAccount::tick() noexcept
{
    if (seen_.ticks >= options_.ticks.value_or(endless)) return Flow::stop;
    const std::int64_t start = now();
    const auto period = static_cast<double>(nanoseconds_per_second) / options_.rate;
    if (seen_.ticks == 0) {
        begin_ = start;
    } else {
        // The driver keeps time: late means more than a period after the last tick.
        const auto interval = static_cast<double>(start - last_);
        seen_.late.add(std::llround(interval - period));
        const double passed = std::floor(interval / period + 0.5) - 1;
        if (passed >= 1) {
            ++seen_.missed;
            seen_.skipped += static_cast<std::uint64_t>(passed);
        }
    }
    last_ = start;
    const Flow flow = tick_(seen_.ticks);
    const std::int64_t end = now();
    seen_.work.add(end - start);
    ++seen_.ticks;
    seen_.seconds = static_cast<double>(end - begin_) / static_cast<double>(nanoseconds_per_second);
    return flow == Flow::stop || seen_.ticks >= options_.ticks.value_or(endless) ? Flow::stop
                                                                                 : Flow::proceed;
}

} // namespace proxima
