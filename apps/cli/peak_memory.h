// How much memory something took at most, as the kernel counts it for the whole process.
#pragma once

#include <cstdint>
#include <optional>

namespace proxima {

/// Notes what memory of this process is resident now; bytes() says how far it rose above that since
/// then. Whatever other threads take counts as well, and so do files that are mapped and read; what
/// is freed and taken again does not. Linux alone: elsewhere, and where /proc is not there,
/// nothing.
class PeakMemory {
public:
    /// Gives back what the allocator keeps for later and resets the kernel's high-water mark.
    PeakMemory();

    [[nodiscard]] std::optional<std::uint64_t> bytes() const;

private:
    std::optional<std::uint64_t> before_;
};

} // namespace proxima
