#include "cli/progress_bar.h"

#include "cli/stderr_text.h"

#include <chrono>
#include <exception>
#include <string_view>
#include <unistd.h>

namespace proxima {

namespace {

constexpr auto first_shown_after = std::chrono::milliseconds(300);
constexpr auto shown_every = std::chrono::milliseconds(100);
constexpr auto line_every = std::chrono::seconds(5);

void print_bar(const Progress& progress)
{
    constexpr int width = 40;
    const double fraction = progress.fraction();
    const int filled = static_cast<int>(fraction * width);
    print_stderr("\r\x1b[K[{:#<{}}{:.<{}}] {:3.0f} % {}", "", filled, "", width - filled,
                 100 * fraction, progress.cancelled() ? "stopping" : progress.stage());
}

} // namespace

ProgressBar::ProgressBar(const Progress& progress, BarMode mode)
{
    const bool terminal = isatty(STDERR_FILENO) != 0;
    if (mode == BarMode::off || (mode == BarMode::automatic && !terminal)) return;
    try {
        thread_ = std::thread(
            [this, &progress, terminal] { terminal ? show(progress) : print_lines(progress); });
    } catch (const std::exception&) {
        return; // no memory or no thread for it: the work is what matters
    }
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
    std::string_view last;
    auto printed = std::chrono::steady_clock::now();
    while (!ending_.wait_for(lock, shown_every, [this] { return ended_; })) {
        const std::string_view stage = progress.cancelled() ? "stopping" : progress.stage();
        const auto now = std::chrono::steady_clock::now();
        if (stage.empty() || (stage == last && now - printed < line_every)) continue;
        print_stderr("proxima: {}, {:.0f} %\n", stage, 100 * progress.fraction());
        last = stage;
        printed = now;
    }
}

void ProgressBar::show(const Progress& progress)
{
    std::unique_lock lock(mutex_);
    if (ending_.wait_for(lock, first_shown_after, [this] { return ended_; })) return;
    do {
        print_bar(progress);
    } while (!ending_.wait_for(lock, shown_every, [this] { return ended_; }));
    write_stderr("\r\x1b[K");
}

} // namespace proxima
