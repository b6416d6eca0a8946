#include "base/text.h"
#include "cli/npy_header.h"
#include "cli/table_reader.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace proxima {

namespace {

/// The product; nothing where it has no room.
std::optional<std::uint64_t> product(std::span<const std::uint64_t> numbers)
{
    std::uint64_t result = 1;
    for (const std::uint64_t number : numbers) {
        if (number != 0 && result > std::numeric_limits<std::uint64_t>::max() / number)
            return std::nullopt;
        result *= number;
    }
    return result;
}

class NpyReader {
public:
    NpyReader(InputBytes& input, const TableForm& form, MemoryBudget budget)
        : input_(input), form_(form), budget_(budget)
    {
        table_.name = input.name();
    }

    Result<NumberTable> read(std::string buffer)
    {
        auto header = parse_npy_header(buffer);
        if (!header) return fail(header.error().code, header.error().message, input_.name());
        header_ = std::move(*header);
        if (Status status = take_shape(); !status) return tl::unexpected(status.error());
        if (Status status = reserve_numbers(table_.values, count_, input_.name(), budget_); !status)
            return tl::unexpected(status.error());
        table_.values.resize(count_);
        buffer.erase(0, header_.length);
        const std::size_t step = header_.bytes_per_number;
        for (std::uint64_t position = 0;;) {
            std::size_t used = 0;
            for (; used + step <= buffer.size() && position < count_; used += step, ++position) {
                if (Status status = store(position, npy_number(header_, buffer.data() + used));
                    !status)
                    return tl::unexpected(status.error());
            }
            buffer.erase(0, used);
            if (position == count_ && !buffer.empty())
                return refuse("more bytes follow its numbers");
            const std::size_t held = buffer.size();
            buffer.resize(held + table_piece);
            const auto more = input_.read(buffer.data() + held, table_piece);
            if (!more) return tl::unexpected(more.error());
            buffer.resize(held + *more);
            if (*more > 0) continue;
            if (position == count_) return std::move(table_);
            return refuse(concat("it ends after ", position, " of ", count_, " numbers"));
        }
    }

private:
    /// Rows and columns, or all of the array as one row.
    Status take_shape()
    {
        const std::span<const std::uint64_t> shape = header_.shape;
        const auto count = product(shape);
        const auto columns = product(shape.subspan(1));
        if (!count || !columns) return refuse("its shape is larger than any file");
        table_.layout = shape.size() > 1 ? find_layout(form_, *columns) : form_.layouts.size();
        if (table_.layout == form_.layouts.size()) table_.layout = find_layout(form_, *count);
        if (*count == 0) {
            return fail(ErrorCode::malformed_file, concat("no row of ", form_.layouts[0], " in it"),
                        input_.name());
        }
        if (table_.layout == form_.layouts.size()) {
            return refuse(concat("the array has ", shape.size() > 1 ? *columns : *count,
                                 " columns: ", what_is_taken(form_)));
        }
        count_ = *count;
        table_.columns = column_count(form_.layouts[table_.layout]);
        infinite_ = infinite_columns(form_, table_.layout);
        const std::size_t row_bytes = table_.columns * header_.bytes_per_number;
        if (!input_.size()) return {};
        const std::uint64_t present = *input_.size() - header_.length;
        if (count_ / table_.columns > present / row_bytes ||
            count_ * header_.bytes_per_number != present) {
            return refuse(concat("the header says ", count_ / table_.columns, " rows of ",
                                 row_bytes, " bytes, ", present,
                                 " bytes follow: write the file again"));
        }
        return {};
    }

    /// The number that comes at `position` in the file.
    Status store(std::uint64_t position, double value)
    {
        std::uint64_t place = position;
        if (header_.order == NpyOrder::columns_first) {
            // The first index runs fastest there, the last one here.
            place = 0;
            for (const std::uint64_t length : header_.shape) {
                place = place * length + position % length;
                position /= length;
            }
        }
        table_.values[place] = value;
        if (std::isfinite(value) || (!std::isnan(value) && infinite_[place % table_.columns]))
            return {};
        return fail(ErrorCode::malformed_file,
                    concat(value, " is no finite number: leave the row out"),
                    concat(table_.place_of(place / table_.columns), " from 0"));
    }

    [[nodiscard]] tl::unexpected<Error> refuse(std::string message) const
    {
        return fail(ErrorCode::malformed_file, std::move(message), input_.name());
    }

    InputBytes& input_;
    const TableForm& form_;
    MemoryBudget budget_;
    NpyHeader header_;
    std::uint64_t count_ = 0;
    std::vector<bool> infinite_; ///< by column
    NumberTable table_;
};

} // namespace

Result<NumberTable> read_npy_table(InputBytes& input, std::string start, const TableForm& form,
                                   MemoryBudget budget)
{
    return NpyReader(input, form, budget).read(std::move(start));
}

} // namespace proxima
