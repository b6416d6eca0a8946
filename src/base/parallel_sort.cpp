#include "base/parallel_sort.h"

#include "base/parallel.h"
#include "base/progress.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t most_chunks = 64; // not by the number of threads: the same work for any
constexpr std::size_t least_chunk = 16384;
constexpr std::size_t buckets = std::size_t{1} << radix_digit_bits;
constexpr std::size_t buckets_per_task = 16;
constexpr std::size_t short_bucket = 8192; // as many as caches hold

} // namespace

bool sort_keys(GrowBuffer<KeyedIndex>& items, unsigned key_bits, Threads threads,
               Progress* progress)
{
    begin_stage(progress, "sorting", items.size());
    const unsigned rest_bits = key_bits - radix_digit_bits;
    const std::size_t per_chunk = std::max(least_chunk, chunk_count(items.size(), most_chunks));
    const std::size_t chunks = chunk_count(items.size(), per_chunk);
    const auto chunk_of = [&](std::size_t chunk) {
        const std::size_t first = chunk * per_chunk;
        return items.span().subspan(first, std::min(per_chunk, items.size() - first));
    };
    // By the highest digit, keeping the order.
    std::vector<std::size_t> starts(chunks * buckets, 0);
    parallel_for(chunks, threads, [&](std::size_t chunk) {
        for (const KeyedIndex& item : chunk_of(chunk))
            ++starts[chunk * buckets + (item.key >> rest_bits)];
    });
    std::vector<std::size_t> ends(buckets);
    std::size_t total = 0;
    for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
        for (std::size_t chunk = 0; chunk < chunks; ++chunk)
            total += std::exchange(starts[chunk * buckets + bucket], total);
        ends[bucket] = total;
    }
    GrowBuffer<KeyedIndex> sorted;
    sorted.resize(items.size());
    parallel_for(chunks, threads, [&](std::size_t chunk) {
        for (const KeyedIndex& item : chunk_of(chunk))
            sorted[starts[chunk * buckets + (item.key >> rest_bits)]++] = item;
    });
    // Each bucket by the rest.
    parallel_for(buckets / buckets_per_task, threads, [&](std::size_t task) {
        if (is_cancelled(progress)) return;
        const std::size_t first_bucket = task * buckets_per_task;
        std::size_t first = first_bucket == 0 ? 0 : ends[first_bucket - 1];
        const std::size_t begin = first;
        for (std::size_t bucket = first_bucket; bucket < first_bucket + buckets_per_task;
             ++bucket) {
            const std::span<KeyedIndex> own = sorted.span().subspan(first, ends[bucket] - first);
            first = ends[bucket];
            if (own.size() <= short_bucket) {
                std::ranges::sort(own, [](const KeyedIndex& a, const KeyedIndex& b) {
                    return a.key != b.key ? a.key < b.key : a.index < b.index;
                });
                continue;
            }
            std::vector<KeyedIndex> long_bucket(own.begin(), own.end());
            StageSteps steps(nullptr, own.size());
            (void)radix_sort(
                long_bucket, rest_bits,
                [&](const KeyedIndex& item) {
                    return item.key & ((std::uint64_t{1} << rest_bits) - 1);
                },
                steps);
            std::ranges::copy(long_bucket, own.begin());
        }
        advance_stage(progress, first - begin);
    });
    items = std::move(sorted);
    return !is_cancelled(progress);
}

} // namespace proxima
