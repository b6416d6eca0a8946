// What recordings of points and of tools have in common: numbers that stand for choices, and errors
// that name the file.
#pragma once

#include "base/binary_file.h"
#include "base/progress.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"

#include <span>
#include <string>
#include <vector>

namespace proxima {

/// 0 off, 1 on, 2 observe. In the order in which they came: files without `observe` are read as they
/// were meant.
[[nodiscard]] double guard_number(Guard guard) noexcept;

/// \pre one of these numbers
[[nodiscard]] Guard guard_of_number(double number) noexcept;

/// The greatest number that stands for a Guard.
inline constexpr int last_guard = 2;

/// Error malformed_file where a number that stands for one of a few is none of them: 0 to `most`.
[[nodiscard]] Status check_choice(const std::string& field, double value, int most);

/// What parse(file) finds in a file that was opened. Errors without a place get the name.
template <class Parse>
[[nodiscard]] auto parsed(const Result<BinaryFile>& file, const std::string& name, Parse&& parse)
    -> decltype(parse(*file))
{
    if (!file) return tl::unexpected(file.error());
    auto recording = parse(*file);
    if (!recording && recording.error().where.empty())
        return fail(recording.error().code, recording.error().message, name);
    return recording;
}

/// A copy of a file's ticks. Errors: the first of check(tick, number); cancelled.
template <class Tick, class Check>
[[nodiscard]] Result<std::vector<Tick>> checked_ticks(std::span<const Tick> ticks,
                                                      Progress* progress, Check&& check)
{
    std::vector<Tick> copy;
    copy.reserve(ticks.size());
    StageSteps steps(progress, "checking the ticks", ticks.size());
    for (const Tick& tick : ticks) {
        if (Status status = check(tick, copy.size()); !status)
            return tl::unexpected(std::move(status).error());
        copy.push_back(tick);
        if (!steps.done(1)) return cancelled("checking the ticks");
    }
    steps.finish();
    return copy;
}

} // namespace proxima
