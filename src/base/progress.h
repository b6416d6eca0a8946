// What workers do with a Progress: small steps handed on in blocks, and stopping on request.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace proxima {

/// Reports the beginning of a stage where a progress object is given.
inline void begin_stage(Progress* progress, const char* name, std::uint64_t steps) noexcept
{
    if (progress != nullptr) progress->begin_stage(name, steps);
}

/// Reports finished steps of the stage where a progress object is given.
inline void advance_stage(Progress* progress, std::uint64_t steps) noexcept
{
    if (progress != nullptr) progress->advance(steps);
}

/// True where a progress object is given and asks to stop.
[[nodiscard]] inline bool is_cancelled(const Progress* progress) noexcept
{
    return progress != nullptr && progress->cancelled();
}

/// The error that work stopped on request returns. `what` names the work: "building the octree".
[[nodiscard]] inline tl::unexpected<Error> cancelled(std::string_view what, std::string where = {})
{
    return fail(ErrorCode::cancelled, std::string(what) + " was stopped on request",
                std::move(where));
}

/// One thread's small steps of a stage, handed on in blocks: one comparison per step.
///
///     StageSteps steps(progress, "collecting leaves", leaves.size());
///     for (...) if (!steps.done(1)) return cancelled("collecting leaves");
class StageSteps {
public:
    /// Enters the stage. Progress may be null. A block should take well below 100 ms.
    StageSteps(Progress* progress, const char* name, std::uint64_t steps,
               std::uint64_t block = 4096) noexcept
        : progress_(progress), block_(block)
    {
        begin_stage(progress_, name, steps);
    }

    /// A part of a stage that somebody has entered before.
    StageSteps(Progress* progress, std::uint64_t block) noexcept
        : progress_(progress), block_(block)
    {}

    /// False where the work shall stop.
    [[nodiscard]] bool done(std::uint64_t steps) noexcept
    {
        waiting_ += steps;
        return waiting_ < block_ || report();
    }

    /// Reports what is left of the last block.
    void finish() noexcept { (void)report(); }

private:
    [[nodiscard]] bool report() noexcept
    {
        advance_stage(progress_, waiting_);
        waiting_ = 0;
        return !is_cancelled(progress_);
    }

    Progress* progress_;
    std::uint64_t block_;
    std::uint64_t waiting_ = 0;
};

} // namespace proxima
