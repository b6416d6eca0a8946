#include "cli/interrupt.h"

#include <array>
#include <atomic>
#include <csignal>

namespace proxima {

namespace {

std::atomic<Progress*> watched{nullptr};
std::atomic<int> received{0};

/// SIGHUP: the terminal is closed. SIGQUIT: a session of touching keeps its recording then.
constexpr std::array stopping = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};

extern "C" void cancel_work(int signal)
{
    received.store(signal);
    if (Progress* const progress = watched.load()) progress->cancel();
}

void handle(int signal, void (*handler)(int), int flags) noexcept
{
    struct sigaction action = {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
}

} // namespace

InterruptGuard::InterruptGuard(Progress& progress) noexcept
{
    received.store(0);
    watched.store(&progress);
    for (const int signal : stopping) {
        struct sigaction before = {};
        sigaction(signal, nullptr, &before);
        if (before.sa_handler == SIG_IGN) continue; // nohup, or a job of a script's background
        // The default action returns after the first signal: whoever asks twice need not wait.
        handle(signal, cancel_work, static_cast<int>(SA_RESETHAND) | SA_RESTART);
    }
}

InterruptGuard::~InterruptGuard()
{
    for (const int signal : stopping) {
        struct sigaction now = {};
        sigaction(signal, nullptr, &now);
        if (now.sa_handler == cancel_work) handle(signal, SIG_DFL, 0);
    }
    watched.store(nullptr);
}

int InterruptGuard::signal_number() noexcept
{
    return received.load();
}

} // namespace proxima
