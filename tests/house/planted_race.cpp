// A race on purpose: two threads add to one plain counter. Built only with the thread sanitizer,
// whose report the test expects: were our suppressions to hide real races, this would be hidden
// too.
#include "proxima/base/parallel.h"

#include <iostream>

int main()
{
    int counter = 0;
    proxima::parallel_for(5000000, {2}, [&](std::size_t) { ++counter; });
    std::cout << counter << '\n';
    return 0;
}
