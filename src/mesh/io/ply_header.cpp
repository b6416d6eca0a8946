#include "mesh/io/ply_header.h"

#include "base/text.h"
#include "mesh/io/text_cursor.h"

#include <algorithm>

namespace proxima::detail {

namespace {

using PlyCursor = TextCursor<TextDialect{}>;

std::optional<PlyType> type_of(std::string_view word) noexcept
{
    static constexpr struct {
        std::string_view name;
        PlyType type;
    } types[] = {
        {"char", PlyType::int8},       {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
        {"uint8", PlyType::uint8},     {"short", PlyType::int16},     {"int16", PlyType::int16},
        {"ushort", PlyType::uint16},   {"uint16", PlyType::uint16},   {"int", PlyType::int32},
        {"int32", PlyType::int32},     {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
        {"float", PlyType::float32},   {"float32", PlyType::float32}, {"double", PlyType::float64},
        {"float64", PlyType::float64},
    };
    for (const auto& known : types) {
        if (known.name == word) return known.type;
    }
    return std::nullopt;
}

class HeaderReader {
public:
    explicit HeaderReader(const MeshSource& source) noexcept
        : source_(source), cursor_(without_byte_order_mark(source.text))
    {}

    Result<PlyHeader> read()
    {
        if (cursor_.word() != "ply" || !cursor_.at_line_end()) {
            return refuse(ErrorCode::malformed_file,
                          "a PLY file starts with the line \"ply\", this one does not");
        }
        while (true) {
            cursor_.skip_line();
            if (cursor_.at_end()) {
                return refuse(ErrorCode::malformed_file,
                              "the file ends before end_header: it is cut off");
            }
            line_ = cursor_.position();
            const std::string_view keyword = cursor_.word();
            if (keyword == "end_header") break;
            if (keyword == "comment" || keyword == "obj_info") continue;
            if (auto status = read_line(keyword); !status) return tl::unexpected(status.error());
            if (!cursor_.at_line_end()) {
                return refuse(ErrorCode::malformed_file,
                              concat("a header line has more words than \"", keyword, "\" takes"));
            }
        }
        return finish();
    }

private:
    [[nodiscard]] tl::unexpected<Error> refuse(ErrorCode code, std::string message) const
    {
        return fail(code, std::move(message), source_.at_line(line_));
    }

    Status read_line(std::string_view keyword)
    {
        if (keyword == "format") return read_format();
        if (keyword == "element") return read_element();
        if (keyword == "property") return read_property();
        return refuse(ErrorCode::malformed_file,
                      concat("\"", keyword.substr(0, 40), "\" is no keyword of a PLY header"));
    }

    Status read_format()
    {
        if (has_format_) {
            return refuse(ErrorCode::malformed_file, "the header has a second format line");
        }
        has_format_ = true;
        const std::string_view encoding = cursor_.word();
        const std::string_view version = cursor_.word();
        if (encoding == "ascii") {
            header_.body_kind = PlyBody::ascii;
        } else if (encoding == "binary_little_endian") {
            header_.body_kind = PlyBody::little_endian;
        } else if (encoding == "binary_big_endian") {
            header_.body_kind = PlyBody::big_endian;
        } else {
            return refuse(ErrorCode::unsupported_format,
                          concat("the encoding \"", encoding.substr(0, 40),
                                 "\" is none of ascii, binary_little_endian, binary_big_endian"));
        }
        if (version != "1.0") {
            return refuse(
                ErrorCode::unsupported_format,
                concat("PLY version 1.0 is read, this is \"", version.substr(0, 40), "\""));
        }
        return {};
    }

    Status read_element()
    {
        const std::string_view name = cursor_.word();
        std::int64_t count = 0;
        if (name.empty() || !cursor_.integer(count) || count < 0) {
            return refuse(ErrorCode::malformed_file,
                          "an element line is \"element NAME COUNT\" with a count of 0 or more");
        }
        const bool known = std::ranges::any_of(
            header_.elements, [&](const PlyElement& element) { return element.name == name; });
        if (known) {
            return refuse(ErrorCode::malformed_file,
                          concat("the header has a second element \"", name.substr(0, 40), "\""));
        }
        if (header_.elements.size() == max_elements) {
            return refuse(ErrorCode::limit_exceeded,
                          concat("the header has more than ", max_elements, " elements"));
        }
        header_.elements.push_back({name, static_cast<std::uint64_t>(count), {}});
        return {};
    }

    Status read_property()
    {
        if (header_.elements.empty()) {
            return refuse(ErrorCode::malformed_file, "a property stands before the first element");
        }
        PlyProperty property;
        std::string_view type = cursor_.word();
        if (type == "list") {
            const std::string_view length_type = cursor_.word();
            property.length_type = type_of(length_type);
            if (!property.length_type) return unknown_type(length_type);
            type = cursor_.word();
        }
        const auto known_type = type_of(type);
        if (!known_type) return unknown_type(type);
        property.type = *known_type;
        property.name = cursor_.word();
        if (property.name.empty()) {
            return refuse(ErrorCode::malformed_file, "a property has no name");
        }
        if (++properties_ > max_properties) {
            return refuse(ErrorCode::limit_exceeded,
                          concat("the header has more than ", max_properties, " properties"));
        }
        header_.elements.back().properties.push_back(property);
        return {};
    }

    [[nodiscard]] tl::unexpected<Error> unknown_type(std::string_view type) const
    {
        return refuse(ErrorCode::malformed_file,
                      concat("\"", type.substr(0, 40),
                             "\" is no PLY number type (char, uchar, short, ushort, int, uint, "
                             "float, double or int8 to float64)"));
    }

    // The body starts after "end_header": a binary one right after the line end.
    Result<PlyHeader> finish()
    {
        if (!has_format_) return refuse(ErrorCode::malformed_file, "the header has no format line");
        while (cursor_.take(' ') || cursor_.take('\t')) {
        }
        (void)cursor_.take('\r');
        if (!cursor_.at_end() && !cursor_.take('\n')) {
            return refuse(ErrorCode::malformed_file, "end_header does not stand alone on its line");
        }
        header_.body = {cursor_.position(), cursor_.remaining()};
        return std::move(header_);
    }

    const MeshSource& source_;
    PlyCursor cursor_;
    const char* line_ = cursor_.position();
    PlyHeader header_;
    bool has_format_ = false;
    std::size_t properties_ = 0;

    static constexpr std::size_t max_elements = 1000;
    static constexpr std::size_t max_properties = 10'000;
};

} // namespace

Result<PlyHeader> read_ply_header(const MeshSource& source)
{
    return HeaderReader(source).read();
}

} // namespace proxima::detail
