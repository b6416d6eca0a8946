#include "base/check.h"

#include <cstdio>
#include <cstdlib>

namespace proxima::detail {

void check_failed(const char* file, int line, const std::string& message) noexcept
{
    (void)std::fprintf(stderr, "%s:%d: check failed: %s\n", file, line, message.c_str());
    std::abort();
}

} // namespace proxima::detail
