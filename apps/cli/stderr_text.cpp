#include "cli/stderr_text.h"

#include "base/signal_block.h"

#include <cerrno>
#include <csignal>
#include <unistd.h>

namespace proxima {

void write_stderr(std::string_view text) noexcept
{
    const SignalBlock block(SIGPIPE); // of a pipe that nobody reads any more
    while (!text.empty()) {
        const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0 && errno == EPIPE) block.take_back();
        if (written <= 0) return;
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

} // namespace proxima
