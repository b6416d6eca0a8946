// The numbers of a NumPy array as rows of a table, one after the other: an array may be larger than
// memory.
#pragma once

#include "cli/input_bytes.h"
#include "cli/npy_header.h"
#include "cli/number_table.h"
#include "proxima/function_ref.h"
#include "proxima/result.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace proxima {

class NpyRows {
public:
    /// Reads the header; `start` is what was read already. `input` and the layouts of the form must
    /// outlive this. Errors as read_number_table.
    [[nodiscard]] static Result<NpyRows> open(InputBytes& input, std::string start,
                                              const TableForm& form);

    [[nodiscard]] std::uint64_t rows() const noexcept { return count_ / columns_; }
    [[nodiscard]] std::size_t columns() const noexcept { return columns_; }
    /// Which of the form's layouts it has.
    [[nodiscard]] std::size_t layout() const noexcept { return layout_; }
    [[nodiscard]] bool has_rows_first() const noexcept
    {
        return header_.order == NpyOrder::rows_first;
    }

    /// Calls take(place, number) for the next numbers of the file, `place` being where a number is in
    /// the table, row by row. Errors: malformed_file (NaN, infinite, cut off, bytes behind the last
    /// number), cancelled. \pre as many are left
    [[nodiscard]] Status read(std::uint64_t numbers,
                              FunctionRef<void(std::uint64_t place, double number)> take);

private:
    NpyRows(InputBytes& input, const TableForm& form) : input_(&input), form_(form) {}

    [[nodiscard]] Status take_shape();
    [[nodiscard]] std::uint64_t place_of(std::uint64_t position) const;
    [[nodiscard]] Status check(std::uint64_t place, double number) const;
    [[nodiscard]] Result<std::size_t> fill();
    [[nodiscard]] tl::unexpected<Error> refuse(std::string message) const;

    InputBytes* input_;
    TableForm form_;
    NpyHeader header_;
    std::uint64_t count_ = 0; ///< of numbers
    std::size_t columns_ = 1;
    std::size_t layout_ = 0;
    std::vector<bool> infinite_; ///< by column, whether it may be
    std::uint64_t position_ = 0; ///< of the next number in the file
    std::string buffer_;         ///< begins with it
};

} // namespace proxima
