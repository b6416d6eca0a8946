#include "cli/peak_memory.h"

#include <fstream>
#include <string>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace proxima {

namespace {

/// Bytes that a line of /proc/self/status says, "VmHWM:" for one.
std::optional<std::uint64_t> status_bytes(const std::string& key)
{
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        std::uint64_t kilobytes = 0;
        if (word == key && status >> kilobytes) return kilobytes * 1024;
    }
    return std::nullopt;
}

} // namespace

PeakMemory::PeakMemory()
{
#ifdef __GLIBC__
    (void)malloc_trim(0);
#endif
    std::ofstream reset("/proc/self/clear_refs");
    reset << 5 << std::flush;
    if (reset) before_ = status_bytes("VmRSS:");
}

std::optional<std::uint64_t> PeakMemory::bytes() const
{
    const auto peak = status_bytes("VmHWM:");
    if (!before_ || !peak) return std::nullopt;
    return *peak > *before_ ? *peak - *before_ : 0;
}

} // namespace proxima
