// A race on purpose: two threads add to plain counters (many, for the sanitizer looks at each place
// once). Built only with the thread sanitizer, whose report the test expects: were our suppressions
// to hide real races, this would be hidden too.
#include "base/parallel.h"

#include <array>
#include <cstddef>
#include <iostream>
#include <numeric>

int main()
{
    std::array<int, 256> counters{};
    proxima::parallel_for(2000000, {2}, [&](std::size_t i) { ++counters[i % counters.size()]; });
    std::cout << std::accumulate(counters.begin(), counters.end(), 0) << '\n';
    return 0;
}
