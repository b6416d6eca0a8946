// Ctrl-C, the request to terminate and the end of the terminal, handed on to the work in progress.
#pragma once

#include "proxima/execution.h"

namespace proxima {

/// While it lives, SIGINT, SIGTERM, SIGHUP and SIGQUIT cancel the work that `progress` watches; one
/// that the program was started to ignore (nohup, a script's background job) stays ignored. A signal
/// that comes again a quarter of a second later ends the program at once. One at a time.
class InterruptGuard {
public:
    explicit InterruptGuard(Progress& progress) noexcept;
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;
    ~InterruptGuard();

    /// The signal that came, 0 if none did.
    [[nodiscard]] static int signal_number() noexcept;
};

} // namespace proxima
