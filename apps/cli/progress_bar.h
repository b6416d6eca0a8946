// A line on the terminal that shows how far long work is; nothing where stderr is no terminal.
#pragma once

#include "proxima/execution.h"

#include <condition_variable>
#include <mutex>
#include <thread>

namespace proxima {

enum class BarMode { automatic, off };

/// Shows `progress` on stderr from its construction to its destruction, then clears the line.
class ProgressBar {
public:
    explicit ProgressBar(const Progress& progress, BarMode mode = BarMode::automatic);
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;
    ~ProgressBar();

private:
    void show(const Progress& progress);

    std::mutex mutex_;
    std::condition_variable ending_;
    bool ended_ = false;
    std::thread thread_;
};

} // namespace proxima
