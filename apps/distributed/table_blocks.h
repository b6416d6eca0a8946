// A table of points or rays that rank 0 reads, shared out block by block.
//
//     rank 0   rows 0 1 2 3 4 5 6 7 8 | 9 ...      a block
//     ranks    0 0 0  1 1 1  2 2 2                 each gets as many rows, in their order
//
// Arrays of NumPy are read block by block, too; of texts rank 0 holds all numbers.
#pragma once

#include "cli/input_bytes.h"
#include "cli/npy_rows.h"
#include "cli/number_table.h"
#include "distributed/world.h"

#include <cstdint>
#include <memory>
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
    /// Has rank 0 open the table. `check_row` is asked about rows before they are shared out.
    /// Collective.
    [[nodiscard]] static Result<TableBlocks>
    open(const TableSource& source, const TableForm& form,
         Status (*check_row)(const NumberTable& table, std::size_t row), World& world);

    /// How many rows the whole table has.
    [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }

    /// A block, and this rank's rows of it.
    struct Block {
        TableRows own;
        TableRows all; ///< on rank 0
    };
    /// The next block, until the one after it is asked for; nothing at the end. Collective.
    [[nodiscard]] Result<std::optional<Block>> next(World& world);

private:
    /// What rank 0 has.
    struct Reader {
        NumberTable table;               ///< all rows, or those of the block
        std::optional<InputBytes> input; ///< of `array`
        std::optional<NpyRows> array;    ///< which is read block by block
    };

    [[nodiscard]] static Status open_reader(const TableSource& source, const TableForm& form,
                                            Reader& reader);
    [[nodiscard]] Result<std::span<const double>> numbers(std::uint64_t first, std::uint64_t rows);

    std::unique_ptr<Reader> reader_ = std::make_unique<Reader>();
    Status (*check_row_)(const NumberTable& table, std::size_t row) = nullptr;
    std::uint64_t rows_ = 0;
    std::size_t columns_ = 0;
    std::uint64_t next_ = 0;
    std::vector<double> own_; ///< of the block
};

} // namespace proxima
