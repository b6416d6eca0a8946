#include "index/lists/shared_blocks.h"

#include "base/check.h"

#include <algorithm>
#include <bit>

namespace proxima {

void BlockSharer::begin()
{
    arena_.clear();
    positions_.clear();
    clock_ = 0;
    for (OpenBlock& block : blocks_) block = {};
}

bool BlockSharer::join(OpenBlock& block, std::uint64_t bit, std::span<const std::uint32_t> ranks)
{
    std::array<std::uint32_t, block_triangles> added{};
    std::size_t added_count = 0;
    auto vertices = block.vertices;
    std::size_t vertex_count = block.vertex_count;
    for (const std::uint32_t rank : ranks) {
        if ((open_of_[rank] & bit) != 0) continue;
        if (block.rank_count + added_count == block_triangles) return false;
        added[added_count++] = rank;
        for (const std::uint32_t vertex : source_.triangles[rank]) {
            auto* const end = vertices.data() + vertex_count;
            if (std::find(vertices.data(), end, vertex) != end) continue;
            if (vertex_count == block_vertices) return false;
            vertices[vertex_count++] = vertex;
        }
    }
    for (std::size_t i = 0; i < added_count; ++i) {
        block.ranks[block.rank_count++] = added[i];
        open_of_[added[i]] |= bit;
    }
    block.vertices = vertices;
    block.vertex_count = vertex_count;
    block.last_use = ++clock_;
    return true;
}

BlockSharer::Location BlockSharer::location_in(const OpenBlock& block,
                                               std::span<const std::uint32_t> ranks)
{
    Location location{block.number, 0};
    for (const std::uint32_t rank : ranks) {
        const auto* const found =
            std::find(block.ranks.data(), block.ranks.data() + block.rank_count, rank);
        location.mask |= 1U << (found - block.ranks.data());
    }
    return location;
}

BlockSharer::Location BlockSharer::put(std::span<const std::uint32_t> ranks)
{
    std::uint64_t touched = 0;
    for (const std::uint32_t rank : ranks) touched |= open_of_[rank];
    // By growth, then by slot.
    std::array<std::uint16_t, open_blocks> order{};
    std::size_t candidates = 0;
    for (std::uint64_t left = touched; left != 0; left &= left - 1) {
        const auto slot = static_cast<std::size_t>(std::countr_zero(left));
        std::size_t common = 0;
        for (const std::uint32_t rank : ranks) common += open_of_[rank] >> slot & 1U;
        const std::size_t growth = ranks.size() - common;
        if (3 * common < ranks.size() || blocks_[slot].rank_count + growth > block_triangles)
            continue;
        order[candidates++] = static_cast<std::uint16_t>(growth << 6U | slot);
        if (growth == 0) break;
    }
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(candidates));
    if (candidates > 0 && order[candidates - 1] >> 6U == 0) order[0] = order[candidates - 1];
    for (std::size_t i = 0; i < candidates; ++i) {
        const std::size_t slot = order[i] & 63U;
        if (join(blocks_[slot], std::uint64_t{1} << slot, ranks))
            return location_in(blocks_[slot], ranks);
    }

    std::size_t oldest = 0;
    for (std::size_t slot = 1; slot < open_blocks; ++slot)
        if (blocks_[slot].last_use < blocks_[oldest].last_use) oldest = slot;
    OpenBlock& block = blocks_[oldest];
    const std::uint64_t bit = std::uint64_t{1} << oldest;
    write(block, bit);
    block.number = static_cast<std::uint32_t>(positions_.size());
    positions_.push_back(0);
    PROXIMA_CHECK(join(block, bit, ranks));
    return location_in(block, ranks);
}

void BlockSharer::write(OpenBlock& block, std::uint64_t bit)
{
    if (block.rank_count == 0) return;
    std::array<BlockTriangle, block_triangles> triangles{};
    for (std::size_t i = 0; i < block.rank_count; ++i) {
        triangles[i] = {block.ranks[i], source_.triangles[block.ranks[i]]};
        open_of_[block.ranks[i]] &= ~bit;
    }
    positions_[block.number] =
        append_block(std::span(triangles).first(block.rank_count), source_.positions, arena_);
    block = {};
}

void BlockSharer::end()
{
    for (std::size_t slot = 0; slot < open_blocks; ++slot)
        write(blocks_[slot], std::uint64_t{1} << slot);
}

} // namespace proxima
