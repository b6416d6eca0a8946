#include "index/lists/rank_blocks.h"

#include <algorithm>
#include <array>

namespace proxima {

RankBlocks::RankBlocks(const BlockSource& source)
    : source_(source), block_of_(source.triangles.size()), firsts_(1, 0)
{
    std::array<std::uint32_t, block_vertices> vertices{};
    std::size_t count = 0;
    const auto join = [&](std::uint32_t rank) {
        std::size_t grown = count;
        for (const std::uint32_t vertex : source.triangles[rank]) {
            auto* const end = vertices.data() + grown;
            if (std::find(vertices.data(), end, vertex) != end) continue;
            if (grown == block_vertices) return false;
            vertices[grown++] = vertex;
        }
        count = grown;
        return true;
    };
    for (std::uint32_t rank = 0; rank < source.triangles.size(); ++rank) {
        if (rank - firsts_.back() == block_triangles || !join(rank)) {
            firsts_.push_back(rank);
            count = 0;
            (void)join(rank); // three vertices always fit
        }
        block_of_[rank] = static_cast<std::uint32_t>(firsts_.size() - 1);
    }
    firsts_.push_back(static_cast<std::uint32_t>(source.triangles.size()));
}

std::size_t RankBlocks::append(std::uint32_t block, std::vector<std::byte>& arena) const
{
    std::array<BlockTriangle, block_triangles> triangles{};
    const std::uint32_t first = firsts_[block];
    const std::uint32_t count = firsts_[block + 1] - first;
    for (std::uint32_t i = 0; i < count; ++i)
        triangles[i] = {first + i, source_.triangles[first + i]};
    return append_block(std::span(triangles).first(count), source_.positions, arena);
}

} // namespace proxima
