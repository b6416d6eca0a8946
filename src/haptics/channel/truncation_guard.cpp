#include "haptics/channel/truncation_guard.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <mutex>
#include <sys/mman.h>
#include <utility>

namespace proxima {

namespace {

/// Guarded memory, as a signal handler can read it.
struct GuardedRange {
    std::atomic<bool> taken{false};
    std::atomic<std::byte*> begin{nullptr}; ///< null: none
    std::atomic<std::size_t> size{0};
    std::atomic<bool> replaced{false};
};
static_assert(std::atomic<std::byte*>::is_always_lock_free);

std::array<GuardedRange, 16> guarded_ranges;
struct sigaction earlier_handler {};

/// Calls only mmap, which is a system call and nothing more.
bool replace_memory_at(const void* address) noexcept
{
    const auto at = reinterpret_cast<std::uintptr_t>(address);
    for (GuardedRange& range : guarded_ranges) {
        std::byte* const begin = range.begin.load();
        const auto first = reinterpret_cast<std::uintptr_t>(begin);
        if (begin == nullptr || at < first || at - first >= range.size.load()) continue;
        void* const memory = mmap(begin, range.size.load(), PROT_READ | PROT_WRITE,
                                  MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
        range.replaced.store(true);
        return memory != MAP_FAILED;
    }
    return false;
}

void on_bus_error(int number, siginfo_t* info, void* context)
{
    const int error = errno;
    const bool was_sent = info->si_code <= 0; // by a process: it has no address
    if (!was_sent && replace_memory_at(info->si_addr)) {
        errno = error;
    } else if ((earlier_handler.sa_flags & SA_SIGINFO) != 0) {
        earlier_handler.sa_sigaction(number, info, context);
    } else if (earlier_handler.sa_handler != SIG_DFL && earlier_handler.sa_handler != SIG_IGN) {
        earlier_handler.sa_handler(number);
    } else if (!was_sent || earlier_handler.sa_handler == SIG_DFL) {
        std::signal(number, SIG_DFL);
        if (was_sent) std::raise(number); // an access is tried again: either ends the program
    }
}

void install_handler()
{
    static std::once_flag once;
    std::call_once(once, [] {
        struct sigaction action {};
        action.sa_sigaction = on_bus_error;
        action.sa_flags = SA_SIGINFO;
        sigemptyset(&action.sa_mask);
        sigaction(SIGBUS, &action, &earlier_handler);
    });
}

} // namespace

TruncationGuard::TruncationGuard(std::span<std::byte> mapped)
{
    install_handler();
    for (std::size_t i = 0; i < guarded_ranges.size() && place_ < 0; ++i) {
        GuardedRange& range = guarded_ranges[i];
        if (range.taken.exchange(true)) continue;
        range.size.store(mapped.size());
        range.replaced.store(false);
        range.begin.store(mapped.data());
        place_ = static_cast<int>(i);
    }
}

TruncationGuard::TruncationGuard(TruncationGuard&& other) noexcept
    : place_(std::exchange(other.place_, -1))
{}

TruncationGuard& TruncationGuard::operator=(TruncationGuard&& other) noexcept
{
    std::swap(place_, other.place_);
    return *this;
}

TruncationGuard::~TruncationGuard()
{
    if (place_ < 0) return;
    GuardedRange& range = guarded_ranges[static_cast<std::size_t>(place_)];
    range.begin.store(nullptr);
    range.taken.store(false);
}

bool TruncationGuard::has_acted() const noexcept
{
    return place_ >= 0 && guarded_ranges[static_cast<std::size_t>(place_)].replaced.load();
}

} // namespace proxima
