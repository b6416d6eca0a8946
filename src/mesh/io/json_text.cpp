#include "mesh/io/json_text.h"

#include "base/memory_budget.h"
#include "base/text.h"
#include "mesh/io/number_text.h"

#include <charconv>

namespace proxima::detail {

namespace {

// Writes a code unit of UTF-16 as UTF-8. The halves of a surrogate pair are written one by one, so
// that equal names have equal bytes however they are escaped.
void append_unit(std::string& text, unsigned unit)
{
    if (unit < 0x80) {
        text += static_cast<char>(unit);
    } else if (unit < 0x800) {
        text += static_cast<char>(0xC0U | unit >> 6U);
        text += static_cast<char>(0x80U | (unit & 0x3FU));
    } else {
        text += static_cast<char>(0xE0U | unit >> 12U);
        text += static_cast<char>(0x80U | (unit >> 6U & 0x3FU));
        text += static_cast<char>(0x80U | (unit & 0x3FU));
    }
}

std::optional<std::string> without_escapes(std::string_view raw)
{
    constexpr std::string_view letters = "\"\\/bfnrt";
    constexpr std::string_view meanings = "\"\\/\b\f\n\r\t";
    std::string text;
    text.reserve(raw.size());
    while (!raw.empty()) {
        const char letter = raw.front();
        raw.remove_prefix(1);
        if (letter != '\\') {
            text += letter;
            continue;
        }
        if (raw.empty()) return std::nullopt;
        const char escape = raw.front();
        raw.remove_prefix(1);
        if (escape == 'u') {
            unsigned unit = 0;
            const std::string_view digits = raw.substr(0, 4);
            const auto [end, error] =
                std::from_chars(digits.data(), digits.data() + digits.size(), unit, 16);
            if (error != std::errc{} || end != digits.data() + 4) return std::nullopt;
            append_unit(text, unit);
            raw.remove_prefix(4);
            continue;
        }
        const std::size_t found = letters.find(escape);
        if (found == std::string_view::npos) return std::nullopt;
        text += meanings[found];
    }
    return text;
}

} // namespace

class JsonParser {
public:
    JsonParser(const MeshSource& source, std::string_view text, MemoryBudget budget)
        : source_(source), position_(text.data()), end_(text.data() + text.size()),
          most_values_(static_cast<std::size_t>(budget_bytes(budget) / sizeof(JsonText::Value)))
    {}

    Result<JsonText> parse()
    {
        if (auto status = read_all(); !status) return tl::unexpected(status.error());
        return std::move(json_);
    }

private:
    // Open arrays and objects are kept in a list. Recursion would let the text choose the depth of
    // the stack.
    Status read_all()
    {
        std::vector<JsonText::Id> open;
        do {
            if (auto status = read_value(open); !status) return status;
            if (auto status = close_all(open); !status) return status;
        } while (!open.empty());
        skip_space();
        // Readers of zero-terminated text would stop at a zero byte.
        if (position_ != end_ && *position_ != '\0') return refuse("there is more behind its end");
        return {};
    }

    // Reads one value with its key; of an array or object only the beginning.
    Status read_value(std::vector<JsonText::Id>& open)
    {
        JsonText::Value value;
        if (!open.empty() && json_[open.back()].kind == JsonText::Kind::object) {
            skip_space();
            if (auto status = read_string(value.key); !status) return status;
            if (!take(':')) return refuse("a ':' is missing");
        }
        if (json_.values_.size() >= most_values_) {
            return fail(ErrorCode::budget_exceeded,
                        "its JSON has more values than the budget has memory for: raise it",
                        source_.at_byte(position_));
        }
        skip_space();
        const char first = position_ == end_ ? '\0' : *position_;
        if (first == '{' || first == '[') {
            if (open.size() >= JsonText::max_nesting) {
                return refuse(concat("arrays and objects lie more than ", JsonText::max_nesting,
                                     " deep in each other"));
            }
            ++position_;
            value.kind = first == '{' ? JsonText::Kind::object : JsonText::Kind::array;
            open.push_back(static_cast<JsonText::Id>(json_.values_.size()));
        } else if (first == '"') {
            value.kind = JsonText::Kind::string;
            if (auto status = read_string(value.text); !status) return status;
        } else if (first == '-' || is_digit(first)) {
            value.kind = JsonText::Kind::number;
            position_ = parse_real(position_, end_, value.number);
            if (position_ == nullptr) return refuse("a number is damaged");
        } else if (!take_word("true") && !take_word("false") && !take_word("null")) {
            return refuse("a value is missing");
        }
        value.end = static_cast<JsonText::Id>(json_.values_.size() + 1);
        json_.values_.push_back(value);
        return {};
    }

    // Closes the arrays and objects that end here, up to the next value.
    Status close_all(std::vector<JsonText::Id>& open)
    {
        while (!open.empty()) {
            const JsonText::Id id = open.back();
            const bool is_empty = id + 1 == json_.values_.size();
            const char bracket = json_[id].kind == JsonText::Kind::object ? '}' : ']';
            if (take(bracket)) {
                json_.values_[id].end = static_cast<JsonText::Id>(json_.values_.size());
                open.pop_back();
                continue;
            }
            const bool just_opened = is_empty;
            if (!just_opened && !take(',')) return refuse("a ',' or a bracket is missing");
            return {};
        }
        return {};
    }

    Status read_string(std::string_view& text)
    {
        if (position_ == end_ || *position_ != '"') return refuse("a string is missing");
        const char* const first = ++position_;
        bool has_escapes = false;
        while (position_ != end_ && *position_ != '"') {
            if (*position_ == '\\') {
                has_escapes = true;
                if (++position_ == end_) break;
            }
            ++position_;
        }
        if (position_ == end_) return refuse("a string has no end");
        text = {first, static_cast<std::size_t>(position_ - first)};
        ++position_;
        if (has_escapes) {
            auto resolved = without_escapes(text);
            if (!resolved) return refuse("a string has an unknown escape");
            text = json_.resolved_.emplace_back(std::move(*resolved));
        }
        return {};
    }

    void skip_space()
    {
        while (position_ != end_ && (*position_ == ' ' || *position_ == '\t' ||
                                     *position_ == '\n' || *position_ == '\r')) {
            ++position_;
        }
    }

    bool take(char letter)
    {
        skip_space();
        if (position_ == end_ || *position_ != letter) return false;
        ++position_;
        return true;
    }

    bool take_word(std::string_view word)
    {
        if (!std::string_view(position_, static_cast<std::size_t>(end_ - position_))
                 .starts_with(word)) {
            return false;
        }
        position_ += word.size();
        return true;
    }

    [[nodiscard]] tl::unexpected<Error> refuse(std::string_view what) const
    {
        return fail(ErrorCode::malformed_file, concat("its JSON is damaged: ", what),
                    position_ == nullptr ? source_.name : source_.at_byte(position_));
    }

    const MeshSource& source_;
    const char* position_;
    const char* end_;
    std::size_t most_values_;
    JsonText json_;
};

Result<JsonText> JsonText::parse(const MeshSource& source, std::string_view text,
                                 MemoryBudget budget)
{
    return JsonParser(source, text, budget).parse();
}

std::vector<JsonText::Id> JsonText::children(Id id) const
{
    std::vector<Id> found;
    const Value& value = values_[id];
    if (value.kind != Kind::array && value.kind != Kind::object) return found;
    for (Id child = id + 1; child < value.end; child = values_[child].end) found.push_back(child);
    return found;
}

std::optional<JsonText::Id> JsonText::member(Id id, std::string_view key) const
{
    if (values_[id].kind != Kind::object) return std::nullopt;
    for (Id child = id + 1; child < values_[id].end; child = values_[child].end) {
        if (values_[child].key == key) return child;
    }
    return std::nullopt;
}

double JsonText::number(Id id, std::string_view key, double otherwise) const
{
    const auto found = member(id, key);
    return found && values_[*found].kind == Kind::number ? values_[*found].number : otherwise;
}

} // namespace proxima::detail
