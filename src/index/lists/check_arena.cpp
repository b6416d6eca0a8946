#include "index/lists/check_arena.h"

#include "base/progress.h"
#include "base/text.h"
#include "index/lists/block.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace proxima {

namespace {

constexpr std::uint8_t used_bit = 0x80;
static_assert(block_triangles < used_bit);

tl::unexpected<Error> bad(std::string message, std::size_t byte)
{
    return fail(ErrorCode::broken_invariant, std::move(message), concat("arena byte ", byte));
}

bool all_zero(std::span<const std::byte> bytes)
{
    return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

std::size_t aligned(std::size_t byte)
{
    return (byte + block_alignment - 1) / block_alignment * block_alignment;
}

template <class T>
T value_at(std::span<const std::byte> arena, std::size_t at)
{
    T value;
    std::memcpy(&value, arena.data() + at, sizeof value);
    return value;
}

bool is_representable(const BlockHeader& header)
{
    constexpr std::uint16_t infinite = 0x7F80; // upper half of a float
    const bool finite = std::isfinite(header.origin[0]) && std::isfinite(header.origin[1]) &&
                        std::isfinite(header.origin[2]) && std::isfinite(header.inverse_unit) &&
                        header.inverse_unit > 0;
    return finite && header.slack_size < infinite && header.slack_reach < infinite &&
           header.vertices >= 1 && header.vertices <= block_vertices && header.triangles >= 1 &&
           header.triangles <= block_triangles && header.wide <= 1 && header.unused == 0;
}

BlockLayout layout_of(const BlockHeader& header)
{
    return block_layout(header.vertices, header.triangles, header.wide != 0);
}

/// Positions of vertices and ranks. \pre the block is within the arena
bool has_sound_triangles(std::span<const std::byte> arena, std::size_t at,
                         const BlockHeader& header, std::uint64_t rows)
{
    const BlockLayout layout = layout_of(header);
    for (std::size_t i = 0; i < header.triangles; ++i) {
        const unsigned corners = value_at<std::uint16_t>(arena, at + layout.corners + 2 * i);
        const unsigned highest = std::max({corners & 31U, corners >> 5U & 31U, corners >> 10U});
        if (highest >= header.vertices) return false;
        const std::uint64_t rank =
            std::uint64_t{header.base} +
            (header.wide != 0 ? value_at<std::uint32_t>(arena, at + layout.ranks + 4 * i)
                              : value_at<std::uint16_t>(arena, at + layout.ranks + 2 * i));
        if (rank >= rows) return false;
    }
    return true;
}

} // namespace

ArenaChecker::ArenaChecker(std::span<const std::byte> arena, std::uint64_t rows)
    : arena_(arena), rows_(rows), states_(arena.size() / block_alignment)
{}

Status ArenaChecker::check_blocks(const CheckWork& work)
{
    if (Status status = walk_headers(work); !status) return status;
    return work.run(tasks_.size() - 1, [&](std::size_t task) { return check_contents(task); });
}

Status ArenaChecker::walk_headers(const CheckWork& work)
{
    if (arena_.size() < block_padding) return bad("the arena has no padding", 0);
    const std::size_t limit = arena_.size() - block_padding;
    StageSteps steps = work.steps();
    // Without a block where no leaf has a list.
    for (std::size_t at = 0; limit != 0; at = aligned(at)) {
        if (limit - at < sizeof(BlockHeader)) return bad("a block is damaged", at);
        const auto header = value_at<BlockHeader>(arena_, at);
        if (!is_representable(header)) return bad("a block is damaged", at);
        const std::size_t bytes = layout_of(header).end;
        if (bytes > limit - at) return bad("a block is damaged", at);
        states_[at / block_alignment].store(header.triangles, std::memory_order_relaxed);
        ++blocks_;
        if (tasks_.empty() || at - tasks_.back() >= CheckWork::task_bytes) tasks_.push_back(at);
        if (!steps.done(bytes)) return cancelled("checking the index");
        at += bytes;
        if (at == limit) break;
        if (aligned(at) >= limit) return bad("the last block is damaged", at);
        if (!all_zero(arena_.subspan(at, aligned(at) - at))) return bad("bytes between blocks", at);
    }
    tasks_.push_back(limit);
    if (!all_zero(arena_.subspan(limit))) return bad("the padding is damaged", limit);
    return {};
}

Status ArenaChecker::check_contents(std::size_t task) const
{
    for (std::size_t at = tasks_[task]; at < tasks_[task + 1];) {
        const auto header = value_at<BlockHeader>(arena_, at);
        if (!has_sound_triangles(arena_, at, header, rows_)) return bad("a block is damaged", at);
        at = aligned(at + layout_of(header).end);
    }
    return {};
}

std::uint32_t ArenaChecker::use(std::uint32_t position, std::uint32_t mask) noexcept
{
    if (position >= states_.size()) return 0;
    std::atomic<std::uint8_t>& state = states_[position];
    const unsigned known = state.load(std::memory_order_relaxed);
    const unsigned triangles = known & ~unsigned{used_bit}; // 0 where no block begins
    if (static_cast<std::uint64_t>(mask) >> triangles != 0) return 0;
    const auto named = static_cast<std::uint32_t>(std::popcount(mask));
    if (named > list_triangles) return 0;
    if ((known & used_bit) == 0) state.fetch_or(used_bit, std::memory_order_relaxed);
    return named;
}

bool ArenaChecker::all_used() const noexcept
{
    return std::ranges::all_of(states_, [](const std::atomic<std::uint8_t>& state) {
        const unsigned known = state.load(std::memory_order_relaxed);
        return known == 0 || (known & used_bit) != 0;
    });
}

} // namespace proxima
