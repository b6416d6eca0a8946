// Keeps a signal that a write() raises from ending the process: the write fails all the same, and says why.
#pragma once

#include <csignal>
#include <ctime>
#include <pthread.h>

namespace proxima {

/// Of the calling thread, while it lives. Async-signal-safe.
class SignalBlock {
public:
    explicit SignalBlock(int signal) noexcept
    {
        sigemptyset(&signal_);
        sigaddset(&signal_, signal);
        pthread_sigmask(SIG_BLOCK, &signal_, &before_);
    }
    SignalBlock(const SignalBlock&) = delete;
    SignalBlock& operator=(const SignalBlock&) = delete;
    ~SignalBlock() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

    /// Takes back the signal that a call has raised, which would be delivered later.
    void take_back() const noexcept
    {
        const timespec no_wait{};
        (void)sigtimedwait(&signal_, nullptr, &no_wait);
    }

private:
    sigset_t signal_{};
    sigset_t before_{};
};

} // namespace proxima
