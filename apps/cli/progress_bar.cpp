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
constexpr auto line_every = std::chrono::seconds(5);

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
    const bool terminal = isatty(STDERR_FILENO) != 0;
    if (mode == BarMode::off || (mode == BarMode::automatic && !terminal)) return;
    thread_ = std::thread(
        [this, &progress, terminal] { terminal ? show(progress) : print_lines(progress); });
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

void ProgressBar::print_lines(const Progress& progress)
{
    std::unique_lock lock(mutex_);
    std::string last;
    auto printed = std::chrono::steady_clock::now();
    while (!ending_.wait_for(lock, shown_every, [this] { return ended_; })) {
        const std::string stage = progress.cancelled() ? "stopping" : progress.stage();
        const auto now = std::chrono::steady_clock::now();
        if (stage.empty() || (stage == last && now - printed < line_every)) continue;
        fmt::print(stderr, "proxima: {}, {:.0f} %\n", stage, 100 * progress.fraction());
        std::fflush(stderr);
        last = stage;
        printed = now;
    }
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
