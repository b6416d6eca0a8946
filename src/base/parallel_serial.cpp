// The loops on the calling thread alone, for builds without oneTBB (PROXIMA_WITH_TBB=OFF).
#include "base/parallel.h"

namespace proxima {

int thread_count(Threads /*threads*/) noexcept
{
    return 1;
}

void parallel_for(std::size_t count, Threads /*threads*/, FunctionRef<void(std::size_t)> body)
{
    for (std::size_t index = 0; index < count; ++index) body(index);
}

} // namespace proxima
