// What loops of several threads and of one have in common.
#include "base/parallel.h"

#include <algorithm>

namespace proxima {

void parallel_chunks(std::size_t count, std::size_t chunk, Threads threads,
                     FunctionRef<void(std::size_t first, std::size_t end)> body)
{
    parallel_for(chunk_count(count, chunk), threads,
                 [&](std::size_t i) { body(i * chunk, std::min(count, (i + 1) * chunk)); });
}

} // namespace proxima
