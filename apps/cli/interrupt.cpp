#include "cli/interrupt.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace proxima {

namespace {

std::atomic<Progress*> watched{nullptr};
std::atomic<int> received{0};

/// SIGHUP: the terminal is closed. SIGQUIT: a session of touching keeps its recording then.
constexpr std::array stopping = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};

/// A signal that comes again sooner is the same request: shells and wrappers send it more than once,
/// and a session of touching lets the force fade meanwhile.
constexpr std::int64_t same_request = 250'000'000; // ns

/// When the first signal of each kind came, ns; 0 for none.
std::array<std::atomic<std::int64_t>, stopping.size()> first_came{};

/// Async-signal-safe.
std::int64_t now() noexcept
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1'000'000'000 * std::int64_t{time.tv_sec} + time.tv_nsec;
}

void handle(int signal, void (*handler)(int), int flags) noexcept
{
    struct sigaction action = {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
}

extern "C" void cancel_work(int signal)
{
    std::size_t kind = 0;
    while (stopping[kind] != signal) ++kind;
    std::int64_t none = 0;
    if (!first_came[kind].compare_exchange_strong(none, now()) && now() - none >= same_request) {
        handle(signal, SIG_DFL, 0); // whoever asks twice need not wait
        raise(signal);
        return;
    }
    received.store(signal);
    if (Progress* const progress = watched.load()) progress->cancel();
}

} // namespace

InterruptGuard::InterruptGuard(Progress& progress) noexcept
{
    received.store(0);
    for (auto& time : first_came) time.store(0);
    watched.store(&progress);
    for (const int signal : stopping) {
        struct sigaction before = {};
        sigaction(signal, nullptr, &before);
        if (before.sa_handler == SIG_IGN) continue; // nohup, or a job of a script's background
        handle(signal, cancel_work, SA_RESTART);
    }
}

InterruptGuard::~InterruptGuard()
{
    for (const int signal : stopping) {
        struct sigaction current = {};
        sigaction(signal, nullptr, &current);
        if (current.sa_handler == cancel_work) handle(signal, SIG_DFL, 0);
    }
    watched.store(nullptr);
}

int InterruptGuard::signal_number() noexcept
{
    return received.load();
}

} // namespace proxima
