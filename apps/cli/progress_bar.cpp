#include "cli/progress_bar.h"

#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <string>
#include <unistd.h>

namespace proxima {

namespace {

constexpr auto first_shown_after = std::chrono::milliseconds(300);
constexpr auto shown_every = std::chrono::milliseconds(100);

std::string bar_line(const Progress& progress)
{
    constexpr int width = 40;
    const double fraction = progress.fraction();
    const auto filled = static_cast<std::size_t>(fraction * width);
    return fmt::format("[{}{}] {:3.0f} % {}", std::string(filled, '#'),
                       std::string(width - filled, '.'), 100 * fraction,
                       progress.cancelled() ? "stopping" : progress.stage());
}

} // namespace

ProgressBar::ProgressBar(const Progress& progress, BarMode mode)
{
    if (mode == BarMode::off || isatty(STDERR_FILENO) == 0) return;
    thread_ = std::thread([this, &progress] { show(progress); });
}

ProgressBar::~ProgressBar()
{
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    ending_.notify_one();
    thread_.join();
}

void ProgressBar::show(const Progress& progress)
{
    std::unique_lock lock(mutex_);
    if (ending_.wait_for(lock, first_shown_after, [this] { return ended_; })) return;
    do {
        fmt::print(stderr, "\r\x1b[K{}", bar_line(progress));
        std::fflush(stderr);
    } while (!ending_.wait_for(lock, shown_every, [this] { return ended_; }));
    fmt::print(stderr, "\r\x1b[K");
    std::fflush(stderr);
}

} // namespace proxima
