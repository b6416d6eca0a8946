#include "cli/npy_header.h"

#include "base/text.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

namespace proxima {

namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";

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

constexpr std::size_t max_dimensions = 4;

/// (5, 3) and the like.
std::optional<std::vector<std::uint64_t>> parse_shape(DictionaryText& text)
{
    if (!text.take("(")) return std::nullopt;
    std::vector<std::uint64_t> shape;
    while (!text.take(")")) {
        const auto number = text.number();
        if (!number) return std::nullopt;
        shape.push_back(*number);
        if (text.take(",")) continue;
        if (!text.take(")")) return std::nullopt;
        break;
    }
    return shape;
}

/// Kind, size and byte order, such as "<f8", ">i4" or "|u1". False for others.
bool take_kind(std::string_view text, NpyHeader& header)
{
    constexpr std::string_view orders = "<>=|";
    if (text.size() != 3 || orders.find(text[0]) == std::string_view::npos) return false;
    header.big_endian = text[0] == '>';
    header.bytes_per_number = static_cast<std::size_t>(text[2] - '0');
    constexpr std::string_view kinds = "fiu";
    const std::size_t kind = kinds.find(text[1]);
    if (kind == std::string_view::npos) return false;
    header.kind = static_cast<NpyKind>(kind);
    constexpr std::string_view sizes = "1248";
    return sizes.find(text[2]) != std::string_view::npos &&
           (header.kind != NpyKind::real || header.bytes_per_number > 1);
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
    std::optional<std::vector<std::uint64_t>> shape;
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
            if (text.take("False")) {
                order = NpyOrder::rows_first;
            } else if (text.take("True")) {
                order = NpyOrder::columns_first;
            }
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
    NpyHeader header;
    if (!take_kind(kind, header)) {
        return fail(ErrorCode::unsupported_format,
                    concat("its numbers are ", kind,
                           ": save them as floats or whole numbers of up to 64 bits"));
    }
    if (shape->empty() || shape->size() > max_dimensions) {
        return fail(ErrorCode::unsupported_format,
                    concat("the array has ", shape->size(),
                           " dimensions: it must have two, rows and columns"));
    }
    header.order = *order;
    header.shape = std::move(*shape);
    return header;
}

/// The sixteen bits of a float: sign, 5 of the exponent, 10 of the fraction.
double half_number(std::uint64_t bits) noexcept
{
    const auto exponent = static_cast<int>(bits >> 10U & 0x1FU);
    const auto fraction = static_cast<double>(bits & 0x3FFU);
    const double size = exponent == 0    ? std::ldexp(fraction, -24)
                        : exponent == 31 ? (fraction == 0 ? HUGE_VAL : NAN)
                                         : std::ldexp(1024 + fraction, exponent - 25);
    return (bits >> 15U & 1U) != 0 ? -size : size;
}

} // namespace

bool is_npy(std::string_view bytes) noexcept
{
    return bytes.starts_with(npy_magic);
}

double npy_number(const NpyHeader& header, const char* bytes) noexcept
{
    const std::size_t size = header.bytes_per_number; // 1 to 8
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const auto byte = static_cast<unsigned char>(bytes[header.big_endian ? size - 1 - i : i]);
        bits |= std::uint64_t{byte} << 8 * i;
    }
    switch (header.kind) {
    case NpyKind::unsigned_whole:
        return static_cast<double>(bits);
    case NpyKind::signed_whole: {
        // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): size is not 0
        const std::uint64_t sign = std::uint64_t{1} << (8 * size - 1);
        return static_cast<double>(static_cast<std::int64_t>((bits ^ sign) - sign));
    }
    case NpyKind::real:
        break;
    }
    if (size == 8) return std::bit_cast<double>(bits);
    if (size == 4)
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    return half_number(bits);
}

Result<NpyHeader> parse_npy_header(std::string_view bytes)
{
    if (!bytes.starts_with(npy_magic)) return malformed();
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
    return npy_header(std::array{rows, columns}, NpyOrder::rows_first);
}

std::string npy_header(std::span<const std::uint64_t> shape, NpyOrder order)
{
    constexpr std::size_t start = 10;
    std::string dictionary = concat(
        "{'descr': '<f8', 'fortran_order': ", order == NpyOrder::rows_first ? "False" : "True",
        ", 'shape': (");
    for (std::size_t i = 0; i < shape.size(); ++i)
        dictionary += concat(i == 0 ? "" : ", ", shape[i]);
    dictionary += "), }";
    while ((start + dictionary.size() + 1) % 64 != 0) dictionary += ' ';
    dictionary += '\n';
    std::string header(npy_magic);
    header += '\x01';
    header += '\0';
    header += static_cast<char>(dictionary.size() & 0xFFU);
    header += static_cast<char>(dictionary.size() >> 8U);
    return header + dictionary;
}

} // namespace proxima
