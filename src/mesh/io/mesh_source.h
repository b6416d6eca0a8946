// The bytes of a mesh file, and how messages name a position in them.
#pragma once

#include "base/progress.h"
#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace proxima::detail {

/// What a reader reads. The bytes belong to someone else.
struct MeshSource {
    std::string name; ///< for messages
    std::string_view text;

    /// "name:12" for a position in line 12. O(position).
    [[nodiscard]] std::string at_line(const char* position) const;
    /// "name, byte 84", counted from 0.
    [[nodiscard]] std::string at_byte(const char* position) const;
    /// Refuses text of which single carriage returns end the lines: it would read as one line.
    /// Errors: malformed_file. O(first line).
    [[nodiscard]] Status check_line_ends() const;
};

/// Tells the watcher how far the reader is and the reader whether to stop. One comparison per call,
/// but once per MiB.
class ReadProgress {
public:
    ReadProgress(Progress* progress, std::string_view text) noexcept
        : progress_(progress), reported_(text.data()), next_(text.data())
    {
        begin_stage(progress_, "reading mesh", text.size());
    }

    /// False where the reader shall stop.
    [[nodiscard]] bool may_continue(const char* position) noexcept
    {
        return position < next_ || report(position);
    }

private:
    static constexpr std::ptrdiff_t interval = std::ptrdiff_t{1} << 20;

    [[nodiscard]] bool report(const char* position) noexcept
    {
        next_ = position + interval;
        if (progress_ == nullptr) return true;
        progress_->advance(static_cast<std::uint64_t>(position - reported_));
        reported_ = position;
        return !progress_->cancelled();
    }

    Progress* progress_;
    const char* reported_;
    const char* next_;
};

} // namespace proxima::detail
