#include "base/text.h"
#include "cli/names.h"
#include "cli/table_reader.h"
#include "mesh/io/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

namespace proxima {

namespace {

constexpr std::string_view spaces = " \t\r";

std::string_view trimmed(std::string_view text)
{
    const std::size_t first = text.find_first_not_of(spaces);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(spaces) + 1 - first);
}

bool is_space(char letter)
{
    return letter == ' ' || letter == '\t';
}

/// What stands between numbers; a space for spaces and tabs.
char separator_of(std::string_view line)
{
    for (const char letter : {';', ','})
        if (line.find(letter) != std::string_view::npos) return letter;
    return ' ';
}

/// How far the field goes that the line begins with. A quoted one may hold separators.
std::size_t field_length(std::string_view line, char separator)
{
    bool quoted = false;
    for (std::size_t end = 0; end < line.size(); ++end) {
        if (line[end] == '"') quoted = !quoted;
        if (!quoted && (line[end] == separator || (separator == ' ' && is_space(line[end]))))
            return end;
    }
    return line.size();
}

/// The fields of a line, without spaces round them.
std::vector<std::string_view> fields_of(std::string_view line, char separator)
{
    std::vector<std::string_view> fields;
    while (true) {
        const std::size_t end = field_length(line, separator);
        fields.push_back(trimmed(line.substr(0, end)));
        if (end == line.size()) return fields;
        line.remove_prefix(end + 1);
        if (separator == ' ') line = trimmed(line);
    }
}

/// In small letters, without quotes.
std::string name_of_field(std::string_view field)
{
    if (field.size() > 1 && field.front() == '"' && field.back() == '"')
        field = trimmed(field.substr(1, field.size() - 2));
    std::string name(field);
    for (char& letter : name)
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
    return name;
}

/// Whether a field is a number, or meant to be one. "inf" is, "info" is a name.
bool begins_number(std::string_view field)
{
    double value = 0;
    const char* const end = field.data() + field.size();
    const char* const after = detail::parse_real(field.data(), end, value);
    return after != nullptr && (std::isfinite(value) || after == end);
}

/// Whether a number is written without a point and an exponent.
bool is_whole(std::string_view number)
{
    return number.find_first_not_of("+-0123456789") == std::string_view::npos;
}

class TextReader {
public:
    TextReader(InputBytes& input, const TableForm& form, FirstLine first, MemoryBudget budget)
        : input_(input), form_(form), first_(first), budget_(budget)
    {
        table_.name = input.name();
    }

    Result<NumberTable> read(std::string start)
    {
        std::size_t held = start.size();
        std::string buffer = std::move(start);
        buffer.resize(table_piece);
        for (bool more = true; more;) {
            const auto count = input_.read(buffer.data() + held, table_piece - held);
            if (!count) return tl::unexpected(count.error());
            more = *count == table_piece - held;
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
        if (table_.values.empty()) {
            return fail(ErrorCode::malformed_file, concat("no row of ", form_.layouts[0], " in it"),
                        input_.name());
        }
        if (begins_with_numbered_columns_) decide_on_first_row();
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
        const std::size_t comment = line.find('#');
        const std::string_view numbers = trimmed(line.substr(0, comment));
        if (!numbers.empty()) return take_numbers(numbers, line.starts_with('\t'));
        // Names may stand behind # in front of the numbers.
        if (!columns_.empty() || comment == std::string_view::npos) return {};
        const std::string_view names = trimmed(line.substr(comment + 1));
        commented_names_.clear();
        for (const std::string_view field : fields_of(names, separator_of(names)))
            commented_names_.push_back(name_of_field(field));
        return {};
    }

    /// `indented`: by a tab, behind which the header of a column without a name would stand.
    Status take_numbers(std::string_view line, bool indented)
    {
        if (!columns_.empty()) return take_row(line);
        separator_ = separator_of(line);
        std::vector<std::string_view> fields = fields_of(line, separator_);
        const bool header = first_ == FirstLine::may_be_header && !begins_number(fields[0]);
        if (header && indented && separator_ == ' ') fields.insert(fields.begin(), "");
        if (header) return take_header(fields);
        if (commented_names_.size() == fields.size() && use_names(commented_names_))
            return take_row(line);
        if (Status status = use_layout(find_layout(form_, fields.size()), 0, fields.size());
            !status)
            return status;
        Status status = take_row(line);
        begins_with_numbered_columns_ = first_ == FirstLine::may_be_header && are_numbered(fields);
        return status;
    }

    /// Whether columns are numbered from 0, as pandas does where they have no names.
    [[nodiscard]] static bool are_numbered(std::span<const std::string_view> fields)
    {
        for (std::size_t i = 0; i < fields.size(); ++i)
            if (fields[i] != concat(i)) return false;
        return true;
    }

    /// The first row numbers the columns: programs write all numbers of floats with a point or an
    /// exponent, so that it is a header where no other row has a whole number.
    void decide_on_first_row()
    {
        std::string numbers;
        for (std::size_t i = 0; i < table_.columns; ++i) numbers += concat(i == 0 ? "" : ",", i);
        const std::string place = concat(table_.place_of(0), ": ", numbers, " was taken for ");
        if (table_.rows() == 1 || has_whole_numbers_) {
            table_.note = concat(place, "a row of numbers: if it is a header, as pandas writes it "
                                        "for columns without names, remove it (header=False)");
            return;
        }
        table_.note = concat(place, "a header, as pandas writes it for columns without names: if "
                                    "it is a row, write it with decimal points");
        table_.values.erase(table_.values.begin(),
                            table_.values.begin() + static_cast<std::ptrdiff_t>(table_.columns));
        std::vector<NumberTable::Lines>& lines = table_.lines;
        if (lines.size() > 1 && lines[1].row == 1) lines.erase(lines.begin());
        for (NumberTable::Lines& run : lines) {
            if (run.row == 0) {
                ++run.line;
            } else {
                --run.row;
            }
        }
    }

    Status take_header(const std::vector<std::string_view>& fields)
    {
        std::vector<std::string> names(fields.size());
        std::ranges::transform(fields, names.begin(), name_of_field);
        if (use_names(names)) return {};
        // Columns that pandas numbered, behind one of row numbers without a name.
        bool numbered = names[0].empty();
        for (std::size_t i = 1; i < names.size(); ++i)
            numbered = numbered && names[i] == concat(i - 1);
        if (numbered && names.size() > 1)
            return use_layout(find_layout(form_, names.size() - 1), 1, names.size() - 1);
        return refuse_header(names, fields);
    }

    [[nodiscard]] tl::unexpected<Error>
    refuse_header(const std::vector<std::string>& names,
                  const std::vector<std::string_view>& fields) const
    {
        for (const std::string& wanted : split_list(form_.layouts[0])) {
            const auto count = std::ranges::count(names, wanted);
            if (count > 1) return refuse(concat(count, " columns are named ", wanted));
            if (count == 1) continue;
            std::string shown;
            for (const std::string_view field : fields)
                shown += concat(shown.empty() ? "" : ",", field);
            constexpr std::size_t most_shown = 60;
            return refuse(concat("no column is named ", wanted, ": the columns are ",
                                 shown.substr(0, most_shown), ", and ", form_.layouts[0],
                                 " are needed"));
        }
        return refuse(concat("the header must name ", form_.layouts[0]));
    }

    /// Takes the longest layout whose names are there, each once. False where there is none.
    bool use_names(const std::vector<std::string>& names)
    {
        std::size_t best = form_.layouts.size();
        for (std::size_t i = 0; i < form_.layouts.size(); ++i) {
            const auto all = split_list(form_.layouts[i]);
            const bool there = std::ranges::all_of(
                all, [&](const std::string& name) { return std::ranges::count(names, name) == 1; });
            const bool longer =
                best == form_.layouts.size() || all.size() > column_count(form_.layouts[best]);
            if (there && longer) best = i;
        }
        if (best == form_.layouts.size()) return false;
        set_layout(best);
        const auto wanted = split_list(form_.layouts[best]);
        for (const std::string& name : names) {
            const auto found = std::ranges::find(wanted, name);
            columns_.push_back(found == wanted.end()
                                   ? std::optional<std::size_t>()
                                   : static_cast<std::size_t>(found - wanted.begin()));
        }
        return true;
    }

    /// Takes columns as they come, after `skipped` ones.
    Status use_layout(std::size_t layout, std::size_t skipped, std::size_t count)
    {
        if (layout == form_.layouts.size()) {
            return refuse(concat(count, count == 1 ? " number" : " numbers",
                                 " in the line: ", what_is_taken(form_)));
        }
        set_layout(layout);
        columns_.resize(skipped);
        for (std::size_t i = 0; i < count; ++i) columns_.emplace_back(i);
        return {};
    }

    void set_layout(std::size_t layout)
    {
        table_.layout = layout;
        table_.columns = column_count(form_.layouts[layout]);
        infinite_ = infinite_columns(form_, layout);
    }

    Status take_row(std::string_view line)
    {
        std::vector<double>& values = table_.values;
        if (values.size() + table_.columns > values.capacity()) {
            const std::size_t wanted = std::max(2 * values.capacity(), table_piece / 8);
            if (Status status = reserve_numbers(values, wanted, input_.name(), budget_); !status)
                return status;
        }
        const std::size_t row = table_.rows();
        if (table_.lines.empty() ||
            line_ - table_.lines.back().line != row - table_.lines.back().row)
            table_.lines.push_back({row, line_});
        values.resize(values.size() + table_.columns);
        double* const numbers = values.data() + values.size() - table_.columns;
        const char* const end = line.data() + line.size();
        std::size_t column = 0;
        for (const char* position = line.data();; ++column) {
            position = skip_spaces(position, end);
            const char* next = nullptr;
            if (column >= columns_.size()) return refuse_count(line);
            if (columns_[column]) {
                double& value = numbers[*columns_[column]];
                const char* const after = detail::parse_real(position, end, value);
                if (after == nullptr || !ends_field(after, end)) return refuse_field(position, end);
                if (begins_with_numbered_columns_ && is_whole({position, after}))
                    has_whole_numbers_ = true;
                if (!std::isfinite(value) && (std::isnan(value) || !infinite_[*columns_[column]])) {
                    return refuse(concat("column ", column + 1, " is no finite number, but ",
                                         field_at(position, end), ": leave the row out"));
                }
                next = skip_spaces(after, end);
            } else {
                const std::string_view rest = rest_of(position, end);
                next = skip_spaces(position + field_length(rest, separator_), end);
            }
            if (next == end) break;
            position = separator_ == ' ' ? next : next + 1;
        }
        return column + 1 == columns_.size() ? Status() : refuse_count(line);
    }

    static const char* skip_spaces(const char* position, const char* end)
    {
        while (position < end && is_space(*position)) ++position;
        return position;
    }

    /// Whether what follows a number is the end of its field.
    [[nodiscard]] bool ends_field(const char* after, const char* end) const
    {
        if (separator_ == ' ') return after == end || is_space(*after);
        const char* const next = skip_spaces(after, end);
        return next == end || *next == separator_;
    }

    [[nodiscard]] std::string_view field_at(const char* position, const char* end) const
    {
        const std::string_view rest = rest_of(position, end);
        return trimmed(rest.substr(0, field_length(rest, separator_)));
    }

    static std::string_view rest_of(const char* position, const char* end)
    {
        return {position, static_cast<std::size_t>(end - position)};
    }

    [[nodiscard]] tl::unexpected<Error> refuse_count(std::string_view line) const
    {
        const std::size_t count = fields_of(line, separator_).size();
        const std::string numbers =
            concat(count, count == 1 ? " number" : " numbers", " in the line");
        return refuse(
            columns_.size() == table_.columns
                ? concat(numbers, ": ", form_.layouts[table_.layout], " takes ", table_.columns)
                : concat(numbers, ", the header names ", columns_.size()));
    }

    [[nodiscard]] tl::unexpected<Error> refuse_field(const char* position, const char* end) const
    {
        constexpr std::size_t most_shown = 40;
        const std::string_view field = field_at(position, end);
        if (field.empty()) {
            return refuse(concat("a number is missing: ", form_.layouts[table_.layout], " takes ",
                                 table_.columns));
        }
        const bool decimal_comma = separator_ == ';' && field.find(',') != std::string_view::npos;
        return refuse(concat(field.substr(0, most_shown), " is no number",
                             decimal_comma ? ": write a point in place of the comma" : ""));
    }

    [[nodiscard]] tl::unexpected<Error> refuse(std::string message) const
    {
        return fail(ErrorCode::malformed_file, std::move(message),
                    concat(input_.name(), ":", line_));
    }

    InputBytes& input_;
    const TableForm& form_;
    FirstLine first_;
    MemoryBudget budget_;
    NumberTable table_;
    std::uint64_t line_ = 0;
    char separator_ = ',';
    std::vector<std::string> commented_names_;
    std::vector<std::optional<std::size_t>> columns_; ///< by column of the file: that of the layout
    std::vector<bool> infinite_;                      ///< by column of the layout
    bool begins_with_numbered_columns_ = false;       ///< a first row 0,1,2
    bool has_whole_numbers_ = false;                  ///< after such a row
};

} // namespace

Result<NumberTable> read_text_table(InputBytes& input, std::string start, const TableForm& form,
                                    FirstLine first, MemoryBudget budget)
{
    return TextReader(input, form, first, budget).read(std::move(start));
}

} // namespace proxima
