// How far long work is, on stderr: a line that a terminal shows again and again, or, where asked for,
// lines that a file or a pipe keeps.
#pragma once

#include "proxima/execution.h"

#include <condition_variable>
#include <mutex>
#include <thread>

namespace proxima {

enum class BarMode {
    automatic, ///< nothing where stderr is no terminal
    lines,     ///< a line for each stage, and another one every five seconds
    off
};

/// Shows `progress` on stderr from its construction to its destruction; not at all where the system
/// has no thread for it.
class ProgressBar {
public:
    explicit ProgressBar(const Progress& progress, BarMode mode = BarMode::automatic);
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;
    ~ProgressBar();

private:
    /// On a terminal; cleared at the end.
    void show(const Progress& progress);
    void print_lines(const Progress& progress);

    std::mutex mutex_;
    std::condition_variable ending_;
    bool ended_ = false;
    std::thread thread_;
};

} // namespace proxima
