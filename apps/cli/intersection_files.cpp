#include "cli/intersection_files.h"

#include "cli/npy_header.h"

#include <array>
#include <fmt/format.h>
#include <iterator>

namespace proxima {

std::string pair_header(AnswerFormat format, std::uint64_t rows)
{
    return format == AnswerFormat::npy ? npy_header(rows, 3) : "pose,a,b\n";
}

std::string pair_rows(AnswerFormat format, std::uint64_t pose, std::span<const TrianglePair> pairs)
{
    fmt::memory_buffer text;
    for (const TrianglePair& pair : pairs) {
        if (format == AnswerFormat::npy) {
            const std::array<double, 3> row = {static_cast<double>(pose),
                                               static_cast<double>(to_index(pair.a)),
                                               static_cast<double>(to_index(pair.b))};
            const char* const raw = reinterpret_cast<const char*>(row.data());
            text.append(raw, raw + sizeof(row));
        } else {
            fmt::format_to(std::back_inserter(text), "{},{},{}\n", pose, to_index(pair.a),
                           to_index(pair.b));
        }
    }
    return fmt::to_string(text);
}

std::string contour_obj(const IntersectionContour& contour, std::uint64_t pose,
                        std::uint64_t first_vertex)
{
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "o pose_{}\n", pose);
    for (const ContourPoint& point : contour.points) {
        fmt::format_to(out, "v {:.17g} {:.17g} {:.17g}\n", point.position.x(), point.position.y(),
                       point.position.z());
    }
    for (const ContourLine& line : contour.lines) {
        fmt::format_to(out, "{}", line.count == 1 ? "p" : "l");
        for (std::size_t i = 0; i < line.count; ++i)
            fmt::format_to(out, " {}", first_vertex + line.first + i);
        if (line.closed) fmt::format_to(out, " {}", first_vertex + line.first);
        fmt::format_to(out, "\n");
    }
    return fmt::to_string(text);
}

} // namespace proxima
