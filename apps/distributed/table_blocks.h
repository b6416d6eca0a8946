// A table of points or rays that rank 0 reads, shared out block by block.
//
//     rank 0   rows 0 1 2 3 4 5 6 7 8 | 9 ...      a block
//     ranks    0 0 0  1 1 1  2 2 2                 each gets as many rows, in their order
#pragma once

#include "cli/number_table.h"
#include "distributed/world.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// Where rows come from: a file, or, where its name is empty, the command line.
struct TableSource {
    std::string file;
    std::vector<std::string> rows;
    std::string option; ///< what errors call `rows`
};

/// Consecutive rows of a table.
struct TableRows {
    std::span<const double> numbers;
    std::size_t columns = 1;
    std::uint64_t first = 0; ///< row of the whole table

    [[nodiscard]] std::size_t size() const noexcept { return numbers.size() / columns; }
    [[nodiscard]] std::span<const double> operator[](std::size_t i) const noexcept
    {
        return numbers.subspan(columns * i, columns);
    }
};

class TableBlocks {
public:
    /// Rank 0 reads the table. `check_row(table, i)` returns a Status for each row. Collective.
    template <class CheckRow>
    [[nodiscard]] static Result<TableBlocks> open(const TableSource& source, const TableForm& form,
                                                  const CheckRow& check_row, const World& world)
    {
        TableBlocks blocks;
        const Status status = world.agree_on([&]() -> Status {
            if (world.rank() != 0) return {};
            auto table = source.file.empty() ? parse_number_rows(source.rows, form, source.option)
                                             : read_number_table(source.file, form);
            if (!table) return tl::unexpected(table.error());
            blocks.table_ = std::move(*table);
            for (std::size_t i = 0; i < blocks.table_.rows(); ++i) {
                if (Status checked = check_row(blocks.table_, i); !checked) return checked;
            }
            return {};
        });
        if (!status) return tl::unexpected(status.error());
        const bool reads = world.rank() == 0;
        blocks.rows_ = world.sum(reads ? blocks.table_.rows() : 0);
        blocks.columns_ = world.sum(reads ? blocks.table_.columns : 0);
        return blocks;
    }

    /// Of the whole table.
    [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }

    /// A block, and this rank's rows of it.
    struct Block {
        TableRows own;
        TableRows all; ///< on rank 0
    };
    /// The next block, until the one after it is asked for; nothing at the end. Collective.
    [[nodiscard]] Result<std::optional<Block>> next(World& world);

private:
    NumberTable table_; ///< on rank 0
    std::uint64_t rows_ = 0;
    std::size_t columns_ = 0;
    std::uint64_t next_ = 0;
    std::vector<double> own_; ///< of the block
};

} // namespace proxima
