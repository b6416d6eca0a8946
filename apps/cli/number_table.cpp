#include "cli/number_table.h"

#include "base/file_extension.h"
#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "cli/npy_header.h"
#include "mesh/io/number_text.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

namespace proxima {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers of .npy files are copied");

/// Bytes that are read at once; no line may be longer.
constexpr std::size_t piece = std::size_t{1} << 20U;

std::size_t column_count(std::string_view names)
{
    return 1 + static_cast<std::size_t>(std::ranges::count(names, ','));
}

/// A regular file, read from front to back.
class InputFile {
public:
    [[nodiscard]] static Result<InputFile> open(const std::string& path, Progress* progress)
    {
        std::error_code error;
        const auto status = std::filesystem::status(path, error);
        if (std::filesystem::is_directory(status)) {
            return fail(ErrorCode::file_not_found, "this is a folder: name a file in it", path);
        }
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
            return fail(ErrorCode::file_not_found,
                        "this is not a regular file: copy it to one first", path);
        }
        InputFile file;
        errno = 0;
        file.stream_.open(path, std::ios::binary);
        const std::uint64_t size = std::filesystem::file_size(path, error);
        if (!file.stream_ || error) {
            const int number = errno != 0 ? errno : error.value();
            return fail(ErrorCode::file_not_found,
                        concat("cannot read this file: ", std::generic_category().message(number)),
                        path);
        }
        if (size == 0) {
            return fail(ErrorCode::malformed_file, "the file is empty: write or copy it again",
                        path);
        }
        file.path_ = path;
        file.size_ = size;
        file.progress_ = progress;
        begin_stage(progress, "reading numbers", size);
        return file;
    }

    [[nodiscard]] const std::string& path() const noexcept { return path_; }
    [[nodiscard]] std::uint64_t size() const noexcept { return size_; }

    /// How many bytes came; fewer than asked for at the end alone. Error cancelled, or what the
    /// system says.
    [[nodiscard]] Result<std::size_t> read(char* bytes, std::size_t count)
    {
        if (is_cancelled(progress_)) return cancelled("reading", path_);
        stream_.read(bytes, static_cast<std::streamsize>(count));
        if (stream_.bad()) {
            return fail(ErrorCode::file_not_found, "the system stopped reading this file", path_);
        }
        const auto done = static_cast<std::size_t>(stream_.gcount());
        advance_stage(progress_, done);
        return done;
    }

private:
    std::ifstream stream_;
    std::string path_;
    std::uint64_t size_ = 0;
    Progress* progress_ = nullptr;
};

Status check_memory(const InputFile& file, std::uint64_t bytes, MemoryBudget budget)
{
    return check_budget(budget, bytes, concat("the numbers of ", file.path()), "split the file");
}

/// Reads lines into a table.
class CsvReader {
public:
    CsvReader(InputFile& file, std::string_view names, MemoryBudget budget)
        : file_(file), names_(names), budget_(budget)
    {
        table_.columns = column_count(names);
    }

    Result<NumberTable> read()
    {
        std::string buffer(piece, '\0');
        std::size_t held = 0;
        for (bool more = true; more;) {
            const auto count = file_.read(buffer.data() + held, piece - held);
            if (!count) return tl::unexpected(count.error());
            more = *count == piece - held;
            held += *count;
            const auto used = take_lines({buffer.data(), held}, more);
            if (!used) return tl::unexpected(used.error());
            if (more && *used == 0) {
                ++line_;
                return refuse("no line may be longer than 2^20 bytes");
            }
            held -= *used;
            std::memmove(buffer.data(), buffer.data() + *used, held);
        }
        if (table_.values.empty())
            return fail(ErrorCode::malformed_file, concat("no row of ", names_, " in it"),
                        file_.path());
        return std::move(table_);
    }

private:
    /// Whole lines; without more to come the last one need not end. Returns the bytes used.
    Result<std::size_t> take_lines(std::string_view text, bool more)
    {
        std::size_t used = 0;
        while (used < text.size()) {
            std::size_t end = text.find('\n', used);
            if (end == std::string_view::npos) {
                if (more) break;
                end = text.size();
            }
            ++line_;
            if (Status status = take_line(text.substr(used, end - used)); !status)
                return tl::unexpected(status.error());
            used = std::min(end + 1, text.size());
        }
        return used;
    }

    Status take_line(std::string_view line)
    {
        if (line_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
        line = trimmed(line);
        if (line.empty()) { // fine at the end alone
            if (first_empty_ == 0) first_empty_ = line_;
            return {};
        }
        if (first_empty_ != 0) {
            line_ = first_empty_;
            return refuse("the line is empty: take it out");
        }
        if (line_ == 1 && is_header(line)) return check_header(line);
        return take_row(line);
    }

    static std::string_view trimmed(std::string_view text)
    {
        constexpr std::string_view spaces = " \t\r";
        const std::size_t first = text.find_first_not_of(spaces);
        if (first == std::string_view::npos) return {};
        return text.substr(first, text.find_last_not_of(spaces) + 1 - first);
    }

    /// A line whose first field is no number.
    static bool is_header(std::string_view line)
    {
        double value = 0;
        return detail::parse_real(line.data(), line.data() + line.size(), value) == nullptr;
    }

    Status check_header(std::string_view line)
    {
        std::string names;
        for (const char letter : line) {
            if (letter == ' ' || letter == '\t' || letter == '"' || letter == '#') continue;
            names +=
                letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
        }
        if (names == names_) return {};
        constexpr std::size_t shown = 60;
        return refuse(concat("the columns must be ", names_, ", not ", line.substr(0, shown)));
    }

    Status take_row(std::string_view line)
    {
        std::size_t columns = 0;
        std::vector<double>& values = table_.values;
        if (values.size() + table_.columns > values.capacity()) {
            if (Status status = reserve_more(); !status) return status;
        }
        for (const char* position = line.data();; ++position) {
            const char* const end = line.data() + line.size();
            position = skip_spaces(position, end);
            double value = 0;
            const char* const after = detail::parse_real(position, end, value);
            const char* const next = after == nullptr ? nullptr : skip_spaces(after, end);
            ++columns;
            if (next == nullptr || (next != end && *next != ','))
                return refuse_field(position, end);
            if (!std::isfinite(value)) {
                return refuse(concat("column ", columns, " is no finite number, but ",
                                     field(position, end), ": leave the row out"));
            }
            if (columns <= table_.columns) values.push_back(value);
            position = next;
            if (position == end) break;
        }
        if (columns == table_.columns) return {};
        return refuse(concat(columns, columns == 1 ? " number" : " numbers",
                             " in the line: ", names_, " takes ", table_.columns));
    }

    Status reserve_more()
    {
        std::vector<double>& values = table_.values;
        const std::size_t wanted = std::max<std::size_t>(2 * values.capacity(), piece / 8);
        const std::uint64_t bytes = (wanted + values.capacity()) * sizeof(double);
        if (Status status = check_memory(file_, bytes, budget_); !status) return status;
        try {
            values.reserve(wanted);
        } catch (const std::bad_alloc&) {
            return fail(ErrorCode::budget_exceeded, "no memory for these numbers: split the file",
                        file_.path());
        }
        return {};
    }

    static const char* skip_spaces(const char* position, const char* end)
    {
        while (position < end && (*position == ' ' || *position == '\t')) ++position;
        return position;
    }

    static std::string field(const char* position, const char* end)
    {
        constexpr std::ptrdiff_t shown = 40;
        const char* const comma = std::find(position, end, ',');
        return {position, std::min(comma, position + std::min(shown, end - position))};
    }

    Status refuse_field(const char* position, const char* end)
    {
        const std::string text = field(position, end);
        return refuse(text.empty()
                          ? concat("a number is missing: ", names_, " takes ", table_.columns)
                          : concat(text, " is no number; numbers stand between commas"));
    }

    [[nodiscard]] tl::unexpected<Error> refuse(std::string message) const
    {
        return fail(ErrorCode::malformed_file, std::move(message),
                    concat(file_.path(), ":", line_));
    }

    InputFile& file_;
    std::string_view names_;
    MemoryBudget budget_;
    NumberTable table_;
    std::uint64_t line_ = 0;
    std::uint64_t first_empty_ = 0;
};

/// Stores numbers as they come, whatever the order of the array.
class NpyNumbers {
public:
    NpyNumbers(const NpyHeader& header, NumberTable& table)
        : rows_(header.rows), columns_(header.columns), order_(header.order), table_(table)
    {}

    /// False where the number is not finite.
    bool store(std::uint64_t position, double value)
    {
        row_ = order_ == NpyOrder::rows_first ? position / columns_ : position % rows_;
        const std::uint64_t column =
            order_ == NpyOrder::rows_first ? position % columns_ : position / rows_;
        table_.values[row_ * columns_ + column] = value;
        return std::isfinite(value);
    }

    [[nodiscard]] std::uint64_t last_row() const noexcept { return row_; }

private:
    std::uint64_t rows_;
    std::uint64_t columns_;
    NpyOrder order_;
    NumberTable& table_;
    std::uint64_t row_ = 0;
};

Result<NpyHeader> read_header(InputFile& file, std::string_view names, std::string& buffer)
{
    const std::size_t wanted = std::min<std::uint64_t>(file.size(), max_npy_header);
    const auto count = file.read(buffer.data(), wanted);
    if (!count) return tl::unexpected(count.error());
    buffer.resize(*count);
    auto header = parse_npy_header(buffer);
    if (!header) return fail(header.error().code, header.error().message, file.path());
    if (header->columns != column_count(names)) {
        return fail(ErrorCode::malformed_file,
                    concat("the array has ", header->columns, " columns: ", names, " takes ",
                           column_count(names)),
                    file.path());
    }
    if (header->rows == 0)
        return fail(ErrorCode::malformed_file, concat("no row of ", names, " in it"), file.path());
    const std::uint64_t row_bytes = header->columns * header->bytes_per_number;
    const std::uint64_t present = file.size() - header->length;
    if (header->rows > present / row_bytes || header->rows * row_bytes != present) {
        return fail(ErrorCode::malformed_file,
                    concat("the header says ", header->rows, " rows of ", row_bytes, " bytes, ",
                           present, " bytes follow: write the file again"),
                    file.path());
    }
    return header;
}

Result<NumberTable> read_npy(InputFile& file, std::string_view names, MemoryBudget budget)
{
    std::string buffer(max_npy_header, '\0');
    const auto header = read_header(file, names, buffer);
    if (!header) return tl::unexpected(header.error());
    const std::uint64_t count = header->rows * header->columns;
    if (Status status = check_memory(file, count * sizeof(double), budget); !status)
        return tl::unexpected(status.error());
    NumberTable table;
    table.columns = header->columns;
    try {
        table.values.resize(count);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded, "no memory for these numbers: split the file",
                    file.path());
    }
    buffer.erase(0, header->length);
    NpyNumbers numbers(*header, table);
    const std::size_t step = header->bytes_per_number;
    for (std::uint64_t position = 0; position < count;) {
        std::size_t used = 0;
        for (; used + step <= buffer.size() && position < count; used += step, ++position) {
            double value = 0;
            if (step == sizeof(float)) {
                float single = 0;
                std::memcpy(&single, buffer.data() + used, sizeof single);
                value = static_cast<double>(single);
            } else {
                std::memcpy(&value, buffer.data() + used, sizeof value);
            }
            if (!numbers.store(position, value)) {
                return fail(ErrorCode::malformed_file,
                            concat(value, " is no finite number: leave the row out"),
                            concat(file.path(), ", row ", numbers.last_row(), " from 0"));
            }
        }
        if (position == count) break;
        buffer.erase(0, used);
        const std::size_t held = buffer.size();
        buffer.resize(held + piece);
        const auto more = file.read(buffer.data() + held, piece);
        if (!more) return tl::unexpected(more.error());
        if (*more == 0) {
            return fail(ErrorCode::malformed_file,
                        "the file shrank while it was read: wait until it is written", file.path());
        }
        buffer.resize(held + *more);
    }
    return table;
}

} // namespace

Result<NumberTable> read_number_table(const std::string& path, std::string_view columns,
                                      const NumberTableOptions& options)
{
    auto file = InputFile::open(path, options.execution.progress);
    if (!file) return tl::unexpected(file.error());
    if (lower_case_extension(path) == ".npy")
        return read_npy(*file, columns, options.execution.budget);
    return CsvReader(*file, columns, options.execution.budget).read();
}

} // namespace proxima
