#include "cli/number_table.h"

#include "base/file_extension.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "cli/names.h"
#include "cli/npy_header.h"
#include "cli/table_reader.h"

#include <algorithm>
#include <new>
#include <utility>

namespace proxima {

std::string NumberTable::place_of(std::size_t row) const
{
    if (lines.empty()) return concat(name, ", row ", row);
    const auto after = std::ranges::upper_bound(lines, row, {}, &Lines::row);
    const Lines& run = *std::prev(after);
    return concat(name, ":", run.line + (row - run.row));
}

std::size_t find_layout(const TableForm& form, std::uint64_t columns)
{
    const auto found = std::ranges::find(form.layouts, columns, column_count);
    return static_cast<std::size_t>(found - form.layouts.begin());
}

std::string what_is_taken(const TableForm& form)
{
    std::string text;
    for (const std::string_view names : form.layouts)
        text += concat(text.empty() ? "" : ", or ", names, " takes ", column_count(names));
    return text;
}

std::vector<bool> infinite_columns(const TableForm& form, std::size_t layout)
{
    const std::vector<std::string> allowed = split_list(form.may_be_infinite);
    std::vector<bool> columns;
    for (const std::string& name : split_list(form.layouts[layout]))
        columns.push_back(std::ranges::find(allowed, name) != allowed.end());
    return columns;
}

Status reserve_numbers(std::vector<double>& values, std::uint64_t count, const std::string& name,
                       MemoryBudget budget)
{
    // While they move, the old ones are there too.
    const std::uint64_t bytes = (count + values.capacity()) * sizeof(double);
    if (Status status =
            check_budget(budget, bytes, concat("the numbers of ", name), "split the file");
        !status)
        return status;
    try {
        values.reserve(count);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded, "no memory for these numbers: split the file",
                    name);
    }
    return {};
}

Result<TableStart> open_table(const std::string& path, Progress* progress)
{
    auto input = InputBytes::open(path, progress);
    if (!input) return tl::unexpected(input.error());
    std::string start(max_npy_header, '\0');
    const auto count = input->read(start.data(), start.size());
    if (!count) return tl::unexpected(count.error());
    start.resize(*count);
    if (start.empty()) {
        return fail(ErrorCode::malformed_file,
                    path == from_stdin
                        ? "it is empty: send the numbers to it, and name it for one option only"
                        : "the file is empty: write or copy it again",
                    input->name());
    }
    const bool is_array = is_npy(start) || lower_case_extension(path) == ".npy";
    return TableStart{std::move(*input), std::move(start), is_array};
}

Result<NumberTable> read_number_table(const std::string& path, const TableForm& form,
                                      const NumberTableOptions& options)
{
    auto opened = open_table(path, options.execution.progress);
    if (!opened) return tl::unexpected(opened.error());
    return read_table(std::move(*opened), form, options.execution.budget);
}

Result<NumberTable> read_table(TableStart opened, const TableForm& form, MemoryBudget budget)
{
    if (opened.is_array) return read_npy_table(opened.input, std::move(opened.start), form, budget);
    return read_text_table(opened.input, std::move(opened.start), form, FirstLine::may_be_header,
                           budget);
}

Result<NumberTable> parse_number_rows(std::span<const std::string> rows, const TableForm& form,
                                      const std::string& name)
{
    std::string text;
    for (const std::string& row : rows) text += row + '\n';
    InputBytes input = InputBytes::of_text(std::move(text), name);
    return read_text_table(input, {}, form, FirstLine::is_row, {});
}

} // namespace proxima
