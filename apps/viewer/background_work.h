// One piece of work at a time in a thread of its own, watched and cancelled from another.
//
//     BackgroundWork<Result<Octree>> work;
//     work.start([=](Progress& progress) { return build_octree(*mesh, {.execution = {.progress = &progress}}); });
//     while (!work.is_finished()) draw(work.progress());
//     const auto octree = work.take();
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <atomic>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <thread>

namespace proxima {

/// T is a Result or a Status: memory that runs out is an error of the work, budget_exceeded.
template <class T>
class BackgroundWork {
public:
    BackgroundWork() = default;
    BackgroundWork(const BackgroundWork&) = delete;
    BackgroundWork& operator=(const BackgroundWork&) = delete;
    /// Asks the work to stop and waits for it.
    ~BackgroundWork()
    {
        cancel();
        if (thread_.joinable()) thread_.join();
    }

    /// \pre !is_busy(). `finished` is called by the worker when all is done, as its last act.
    template <class Work>
    void start(Work work, std::function<void()> finished = {})
    {
        result_.reset();
        progress_ = std::make_shared<Progress>();
        done_.store(false);
        thread_ = std::thread([this, work = std::move(work), finished = std::move(finished)] {
            run(work);
            done_.store(true, std::memory_order_release);
            if (finished) finished();
        });
    }

    /// Started and not taken yet.
    [[nodiscard]] bool is_busy() const noexcept { return thread_.joinable(); }
    [[nodiscard]] bool is_finished() const noexcept
    {
        return is_busy() && done_.load(std::memory_order_acquire);
    }

    /// Waits for the work where need be. \pre is_busy()
    [[nodiscard]] T take()
    {
        thread_.join();
        T result = std::move(*result_);
        result_.reset();
        return result;
    }

    void cancel() noexcept
    {
        if (progress_) progress_->cancel();
    }

    /// Of the work at hand, or of the last one. \pre started once
    [[nodiscard]] const Progress& progress() const noexcept { return *progress_; }
    /// For who watches it beyond its end.
    [[nodiscard]] std::shared_ptr<const Progress> shared_progress() const noexcept
    {
        return progress_;
    }

private:
    template <class Work>
    void run(const Work& work)
    {
        try {
            result_.emplace(work(*progress_));
        } catch (const std::bad_alloc&) {
            result_ = fail(ErrorCode::budget_exceeded,
                           "there is not enough memory for this: show less, or a coarser mesh");
        }
    }

    std::thread thread_;
    std::shared_ptr<Progress> progress_;
    std::optional<T> result_;
    std::atomic<bool> done_{false};
};

} // namespace proxima
