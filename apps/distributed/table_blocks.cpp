#include "distributed/table_blocks.h"

#include "distributed/mesh_slice.h"

#include <algorithm>

namespace proxima {

namespace {

/// Rows that each rank has at once: their answers take up to 100 bytes each, twice.
constexpr std::uint64_t rows_per_rank = std::uint64_t{1} << 17U;

} // namespace

Result<std::optional<TableBlocks::Block>> TableBlocks::next(World& world)
{
    if (next_ == rows_) return std::optional<Block>();
    const std::uint64_t first = next_;
    const std::uint64_t rows =
        std::min(rows_per_rank * static_cast<std::uint64_t>(world.size()), rows_ - first);
    next_ += rows;
    Block block;
    std::vector<std::vector<double>> outgoing(static_cast<std::size_t>(world.size()));
    const Status status = world.agree_on([&]() -> Status {
        if (world.rank() != 0) return {};
        const auto values = std::span<const double>(table_.values);
        block.all = {values.subspan(first * columns_, rows * columns_), columns_, first};
        for (int r = 0; r < world.size(); ++r) {
            const Share share = share_of(rows, r, world.size());
            const auto own = block.all.numbers.subspan(share.first * columns_,
                                                       (share.end - share.first) * columns_);
            outgoing[static_cast<std::size_t>(r)].assign(own.begin(), own.end());
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    auto received = world.exchange(std::move(outgoing));
    if (!received) return tl::unexpected(received.error());
    own_ = std::move(received->items);
    block.own = {own_, columns_, first + share_of(rows, world.rank(), world.size()).first};
    return std::optional(block);
}

} // namespace proxima
