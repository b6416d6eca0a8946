// Keeps a program alive whose shared memory another one shortens. Touching pages beyond the new end
// raises SIGBUS, which ends a program. A handler puts memory of this program alone in their place: what
// was shared is no longer, and nobody hears the other, but the servo loop goes on.
//
//     SIGBUS at an address within a guarded range     the range becomes anonymous memory, zeros
//     any other, or sent by a process                 the handler that was there before, or the end
#pragma once

#include <cstddef>
#include <span>

namespace proxima {

/// Guards mapped memory while it lives. The first guard of a program installs the handler, which stays.
/// Constructor and destructor: any thread. At most 16 at a time; further ones guard nothing.
class TruncationGuard {
public:
    TruncationGuard() = default;
    explicit TruncationGuard(std::span<std::byte> mapped);
    TruncationGuard(TruncationGuard&& other) noexcept;
    TruncationGuard& operator=(TruncationGuard&& other) noexcept;
    ~TruncationGuard();

    /// Whether the memory was replaced.
    [[nodiscard]] bool has_acted() const noexcept;

private:
    int place_ = -1; ///< in the handler's table
};

} // namespace proxima
