#include "cli/npy_header.h"

#include "base/text.h"

#include <charconv>
#include <optional>

namespace proxima {

namespace {

constexpr std::string_view magic = "\x93NUMPY";

/// Reads the words of a Python dictionary such as {'descr': '<f8', 'shape': (3, 3), }.
class DictionaryText {
public:
    explicit DictionaryText(std::string_view text) : text_(text) {}

    /// Moves over the token where it comes next, spaces before it too.
    bool take(std::string_view token)
    {
        skip_spaces();
        if (!text_.starts_with(token)) return false;
        text_.remove_prefix(token.size());
        return true;
    }

    /// A word in single quotes.
    std::optional<std::string_view> quoted()
    {
        if (!take("'")) return std::nullopt;
        const std::size_t end = text_.find('\'');
        if (end == std::string_view::npos) return std::nullopt;
        const std::string_view word = text_.substr(0, end);
        text_.remove_prefix(end + 1);
        return word;
    }

    std::optional<std::uint64_t> number()
    {
        skip_spaces();
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
        if (error != std::errc{}) return std::nullopt;
        text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
        return value;
    }

    [[nodiscard]] bool at_end()
    {
        skip_spaces();
        return text_.empty();
    }

private:
    void skip_spaces()
    {
        const std::size_t first = text_.find_first_not_of(" \t\n");
        text_.remove_prefix(first == std::string_view::npos ? text_.size() : first);
    }

    std::string_view text_;
};

struct Shape {
    std::uint64_t rows = 0;
    std::uint64_t columns = 0;
    std::size_t dimensions = 0;
};

/// (5, 3) and the like.
std::optional<Shape> parse_shape(DictionaryText& text)
{
    if (!text.take("(")) return std::nullopt;
    Shape shape;
    while (!text.take(")")) {
        const auto number = text.number();
        if (!number) return std::nullopt;
        (shape.dimensions == 0 ? shape.rows : shape.columns) = *number;
        ++shape.dimensions;
        if (text.take(",")) continue;
        if (!text.take(")")) return std::nullopt;
        break;
    }
    return shape;
}

tl::unexpected<Error> malformed()
{
    return fail(ErrorCode::malformed_file,
                "the header is not one of NumPy's arrays: write it again with numpy.save");
}

Result<NpyHeader> parse_dictionary(std::string_view dictionary)
{
    DictionaryText text(dictionary);
    std::string_view kind;
    std::optional<NpyOrder> order;
    std::optional<Shape> shape;
    if (!text.take("{")) return malformed();
    while (!text.take("}")) {
        const auto key = text.quoted();
        if (!key || !text.take(":")) return malformed();
        if (*key == "descr") {
            const auto word = text.quoted();
            if (!word) {
                return fail(ErrorCode::unsupported_format,
                            "it holds records: save a plain array of float64");
            }
            kind = *word;
        } else if (*key == "fortran_order") {
            if (text.take("False"))
                order = NpyOrder::rows_first;
            else if (text.take("True"))
                order = NpyOrder::columns_first;
        } else if (*key == "shape") {
            shape = parse_shape(text);
        } else {
            return malformed();
        }
        if (!text.take(",")) {
            if (!text.take("}")) return malformed();
            break;
        }
    }
    if (!text.at_end() || kind.empty() || !order || !shape) return malformed();
    if (kind != "<f4" && kind != "<f8") {
        return fail(
            ErrorCode::unsupported_format,
            concat("its numbers are ", kind, ": save them as float32 or float64 (<f4, <f8)"));
    }
    if (shape->dimensions != 2) {
        return fail(ErrorCode::unsupported_format,
                    concat("the array has ", shape->dimensions,
                           " dimensions: it must have two, rows and columns"));
    }
    return NpyHeader{kind == "<f4" ? std::size_t{4} : std::size_t{8}, *order, shape->rows,
                     shape->columns, 0};
}

} // namespace

Result<NpyHeader> parse_npy_header(std::string_view bytes)
{
    if (!bytes.starts_with(magic)) return malformed();
    const auto byte = [&](std::size_t position) {
        return position < bytes.size() ? std::size_t{static_cast<unsigned char>(bytes[position])}
                                       : 0;
    };
    const std::size_t version = byte(6);
    if (version < 1 || version > 3) return malformed();
    const std::size_t start = version == 1 ? 10 : 12;
    const std::size_t high = version == 1 ? 0 : byte(10) << 16U | byte(11) << 24U;
    const std::size_t length = byte(8) | byte(9) << 8U | high;
    if (start + length > bytes.size()) return malformed();
    auto header = parse_dictionary(bytes.substr(start, length));
    if (header) header->length = start + length;
    return header;
}

std::string npy_header(std::uint64_t rows, std::uint64_t columns)
{
    constexpr std::size_t start = 10;
    std::string dictionary =
        concat("{'descr': '<f8', 'fortran_order': False, 'shape': (", rows, ", ", columns, "), }");
    while ((start + dictionary.size() + 1) % 64 != 0) dictionary += ' ';
    dictionary += '\n';
    std::string header(magic);
    header += '\x01';
    header += '\0';
    header += static_cast<char>(dictionary.size() & 0xFFU);
    header += static_cast<char>(dictionary.size() >> 8U);
    return header + dictionary;
}

} // namespace proxima
