#include "cli/npy_rows.h"

#include "base/text.h"
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

} // namespace

Result<NpyRows> NpyRows::open(InputBytes& input, std::string start, const TableForm& form)
{
    auto header = parse_npy_header(start);
    if (!header) return fail(header.error().code, header.error().message, input.name());
    NpyRows rows(input, form);
    rows.header_ = std::move(*header);
    if (Status status = rows.take_shape(); !status) return tl::unexpected(status.error());
    start.erase(0, rows.header_.length);
    rows.buffer_ = std::move(start);
    return rows;
}

Status NpyRows::read(std::uint64_t numbers,
                     FunctionRef<void(std::uint64_t place, double number)> take)
{
    const std::size_t step = header_.bytes_per_number;
    const std::uint64_t end = position_ + numbers;
    while (true) {
        std::size_t used = 0;
        for (; used + step <= buffer_.size() && position_ < end; used += step, ++position_) {
            const double number = npy_number(header_, buffer_.data() + used);
            const std::uint64_t place = place_of(position_);
            if (Status status = check(place, number); !status) return status;
            take(place, number);
        }
        buffer_.erase(0, used);
        if (position_ == end && end < count_) return {};
        if (position_ == end && !buffer_.empty()) return refuse("more bytes follow its numbers");
        const auto more = fill();
        if (!more) return tl::unexpected(more.error());
        if (*more > 0) continue;
        if (position_ == end) return {};
        return refuse(concat("it ends after ", position_, " of ", count_, " numbers"));
    }
}

/// Reads on; gives the bytes that came.
Result<std::size_t> NpyRows::fill()
{
    const std::size_t held = buffer_.size();
    buffer_.resize(held + table_piece);
    auto more = input_->read(buffer_.data() + held, table_piece);
    buffer_.resize(held + more.value_or(0));
    return more;
}

/// Rows and columns, a column, or all of the array as one row.
Status NpyRows::take_shape()
{
    const std::span<const std::uint64_t> shape = header_.shape;
    const auto count = product(shape);
    const auto columns = product(shape.subspan(1));
    constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max() / (4 * sizeof(double));
    if (!count || !columns || *count > most) return refuse("its shape is larger than any file");
    layout_ = find_layout(form_, *columns); // 1 column of an array of one dimension
    if (layout_ == form_.layouts.size()) layout_ = find_layout(form_, *count);
    if (*count == 0) {
        return fail(ErrorCode::malformed_file, concat("no row of ", form_.layouts[0], " in it"),
                    input_->name());
    }
    if (layout_ == form_.layouts.size()) {
        return refuse(concat("the array has ", shape.size() > 1 ? *columns : *count,
                             " columns: ", what_is_taken(form_)));
    }
    count_ = *count;
    columns_ = column_count(form_.layouts[layout_]);
    infinite_ = infinite_columns(form_, layout_);
    const std::size_t row_bytes = columns_ * header_.bytes_per_number;
    if (!input_->size()) return {};
    const std::uint64_t present = *input_->size() - header_.length;
    if (count_ / columns_ > present / row_bytes || count_ * header_.bytes_per_number != present) {
        return refuse(concat("the header says ", count_ / columns_, " rows of ", row_bytes,
                             " bytes, ", present, " bytes follow: write the file again"));
    }
    return {};
}

/// Where the number that comes at `position` in the file is in the table.
std::uint64_t NpyRows::place_of(std::uint64_t position) const
{
    if (has_rows_first()) return position;
    // The first index runs fastest there, the last one here.
    std::uint64_t place = 0;
    for (const std::uint64_t length : header_.shape) {
        place = place * length + position % length;
        position /= length;
    }
    return place;
}

Status NpyRows::check(std::uint64_t place, double number) const
{
    if (std::isfinite(number) || (!std::isnan(number) && infinite_[place % columns_])) return {};
    return fail(ErrorCode::malformed_file,
                concat(number, " is no finite number: leave the row out"),
                concat(input_->name(), ", row ", place / columns_, " from 0"));
}

tl::unexpected<Error> NpyRows::refuse(std::string message) const
{
    return fail(ErrorCode::malformed_file, std::move(message), input_->name());
}

Result<NumberTable> read_npy_table(InputBytes& input, std::string start, const TableForm& form,
                                   MemoryBudget budget)
{
    auto rows = NpyRows::open(input, std::move(start), form);
    if (!rows) return tl::unexpected(rows.error());
    NumberTable table;
    table.name = input.name();
    table.columns = rows->columns();
    table.layout = rows->layout();
    const std::uint64_t count = rows->rows() * rows->columns();
    if (Status status = reserve_numbers(table.values, count, input.name(), budget); !status)
        return tl::unexpected(status.error());
    table.values.resize(count);
    const Status status = rows->read(
        count, [&](std::uint64_t place, double number) { table.values[place] = number; });
    if (!status) return tl::unexpected(status.error());
    return table;
}

} // namespace proxima
