// Sorting of many integer keys with a payload on several threads.
#pragma once

#include "base/grow_buffer.h"
#include "base/radix_sort.h"
#include "proxima/execution.h"

namespace proxima {

/// Sorts by the lowest `key_bits` bits of the keys, ascending; the bits above must be zero. Gives the
/// result of radix_sort where indices ascend. False, with the items in no order, where `progress`
/// asks to stop. About 40 ns an item on one thread, one copy of the items as scratch.
/// \pre indices ascend, key_bits in [11, 64]
[[nodiscard]] bool sort_keys(GrowBuffer<KeyedIndex>& items, unsigned key_bits, Threads threads,
                             Progress* progress);

} // namespace proxima
