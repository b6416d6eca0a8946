#include "distributed/table_blocks.h"

#include "base/text.h"
#include "cli/table_reader.h"
#include "distributed/mesh_slice.h"

#include <algorithm>

namespace proxima {

namespace {

/// Rows that are answered at once. Rank 0 reads them all, and they may all be near one rank's part; a
/// rank's answers take up to 100 bytes each, twice.
std::uint64_t rows_of_block(int ranks) noexcept
{
    constexpr std::uint64_t of_all = std::uint64_t{1} << 20U;
    constexpr std::uint64_t least_of_one = std::uint64_t{1} << 12U;
    constexpr std::uint64_t most_of_one = std::uint64_t{1} << 17U;
    const auto count = static_cast<std::uint64_t>(ranks);
    return count * std::clamp(of_all / count, least_of_one, most_of_one);
}

} // namespace

Result<TableBlocks> TableBlocks::open(const TableSource& source, const TableForm& form,
                                      Status (*check_row)(const NumberTable&, std::size_t),
                                      World& world)
{
    TableBlocks blocks;
    blocks.check_row_ = check_row;
    Reader& reader = *blocks.reader_;
    const Status status = world.agree_on([&]() -> Status {
        return world.rank() == 0 ? open_reader(source, form, reader) : Status{};
    });
    if (!status) return tl::unexpected(status.error());
    const bool reads = world.rank() == 0;
    const std::uint64_t rows = reader.array ? reader.array->rows()
                               : reads      ? reader.table.rows()
                                            : 0;
    blocks.rows_ = world.sum(rows);
    blocks.columns_ = world.sum(reader.table.columns);
    return blocks;
}

Status TableBlocks::open_reader(const TableSource& source, const TableForm& form, Reader& reader)
{
    const auto take = [&](Result<NumberTable> table) -> Status {
        if (!table) return tl::unexpected(table.error());
        reader.table = std::move(*table);
        return {};
    };
    if (source.file.empty()) return take(parse_number_rows(source.rows, form, source.option));
    auto opened = open_table(source.file, nullptr);
    if (!opened) return tl::unexpected(opened.error());
    if (!opened->is_array) return take(read_table(std::move(*opened), form, {}));
    reader.input.emplace(std::move(opened->input));
    auto array = NpyRows::open(*reader.input, opened->start, form);
    if (!array) return tl::unexpected(array.error());
    // What has columns first must be there as a whole.
    if (!array->has_rows_first())
        return take(read_npy_table(*reader.input, std::move(opened->start), form, {}));
    reader.table.name = reader.input->name();
    reader.table.columns = array->columns();
    reader.table.layout = array->layout();
    reader.array = std::move(*array);
    return {};
}

/// On rank 0: rows that come after those before.
Result<std::span<const double>> TableBlocks::numbers(std::uint64_t first, std::uint64_t rows)
{
    NumberTable& table = reader_->table;
    std::uint64_t first_held = first;
    if (reader_->array) {
        table.values.clear();
        table.values.reserve(rows * columns_);
        const Status status = reader_->array->read(
            rows * columns_, [&](std::uint64_t, double number) { table.values.push_back(number); });
        if (!status) return tl::unexpected(status.error());
        first_held = 0;
    }
    for (std::uint64_t i = 0; i < rows; ++i) {
        const Status status = check_row_(table, first_held + i);
        if (status) continue;
        Error error = status.error();
        if (reader_->array) error.where = concat(table.name, ", row ", first + i);
        return tl::unexpected(error);
    }
    return std::span<const double>(table.values).subspan(first_held * columns_, rows * columns_);
}

Result<std::optional<TableBlocks::Block>> TableBlocks::next(World& world)
{
    if (next_ == rows_) return std::optional<Block>();
    const std::uint64_t first = next_;
    const std::uint64_t rows = std::min(rows_of_block(world.size()), rows_ - first);
    next_ += rows;
    Block block;
    std::vector<std::vector<double>> outgoing(static_cast<std::size_t>(world.size()));
    const Status status = world.agree_on([&]() -> Status {
        if (world.rank() != 0) return {};
        const auto read = numbers(first, rows);
        if (!read) return tl::unexpected(read.error());
        block.all = {*read, columns_, first};
        for (int r = 0; r < world.size(); ++r) {
            const Share share = share_of(rows, r, world.size());
            const auto own =
                read->subspan(share.first * columns_, (share.end - share.first) * columns_);
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
