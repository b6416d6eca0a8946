#include "run.h"
#include "unlocked.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

namespace proxima::python {

namespace {

/// Work in a thread of its own. Joined before it goes.
class Worker {
public:
    explicit Worker(FunctionRef<void(Progress*)> work) : thread_([this, work] { run(work); }) {}
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;
    ~Worker() { thread_.join(); }

    [[nodiscard]] bool wait_for(std::chrono::milliseconds time)
    {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, time, [&] { return done_; });
    }

    /// \pre wait_for was true
    void rethrow() const
    {
        if (thrown_) std::rethrow_exception(thrown_);
    }

    [[nodiscard]] Progress& progress() noexcept { return progress_; }

private:
    void run(FunctionRef<void(Progress*)> work) noexcept
    {
        try {
            work(&progress_);
        } catch (...) {
            thrown_ = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        done_ = true;
        changed_.notify_one();
    }

    Progress progress_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::exception_ptr thrown_;
    bool done_ = false;
    std::thread thread_;
};

/// Cancels the work where Python wants it to end.
void look_after(Progress& progress, const py::object& callback)
{
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback.is_none()) return;
    const py::object answer = callback(progress.stage(), progress.fraction());
    py::detail::make_caster<bool> truth;
    const bool is_truth = truth.load(answer, false); // True, False, and NumPy's
    if (is_truth && !static_cast<bool>(truth)) progress.cancel();
}

void run_watched(const py::object& callback, FunctionRef<void(Progress*)> work)
{
    constexpr std::chrono::milliseconds first_wait{5};
    constexpr std::chrono::milliseconds wait{50};
    const Unlocked unlocked;
    Worker worker(work);
    bool done = worker.wait_for(first_wait);
    while (!done) {
        try {
            const py::gil_scoped_acquire locked;
            look_after(worker.progress(), callback);
        } catch (...) {
            worker.progress().cancel();
            throw;
        }
        done = worker.wait_for(wait);
    }
    worker.rethrow();
    if (!worker.progress().cancelled()) {
        const py::gil_scoped_acquire locked;
        look_after(worker.progress(), callback);
    }
}

} // namespace

void run_unlocked(const py::object& callback, Duration duration, FunctionRef<void(Progress*)> work)
{
    if (!callback.is_none() && PyCallable_Check(callback.ptr()) == 0)
        refuse_object(callback, "progress", "None or a function of a stage and a fraction");
    if (duration == Duration::lengthy || !callback.is_none()) {
        run_watched(callback, work);
    } else {
        const Unlocked unlocked;
        work(nullptr);
    }
}

Threads threads_of(Integer count)
{
    return {static_cast<int>(count_of(count, "threads", std::numeric_limits<int>::max()))};
}

} // namespace proxima::python
