#include "cli/intersection_files.h"

#include "cli/npy_header.h"
#include "cli/row_text.h"

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
        append_row(text, format,
                   std::array<double, 3>{static_cast<double>(pose),
                                         static_cast<double>(to_index(pair.a)),
                                         static_cast<double>(to_index(pair.b))});
    }
    return fmt::to_string(text);
}

std::string pose_header(AnswerFormat format, bool with_distance, std::uint64_t rows)
{
    if (format == AnswerFormat::npy) return npy_header(rows, with_distance ? 13 : 4);
    return fmt::format("pose,intersecting,pairs,contained{}\n",
                       with_distance ? ",separation,ax,ay,az,bx,by,bz,triangle_a,triangle_b" : "");
}

std::string pose_row(AnswerFormat format, std::uint64_t pose, const PoseRow& row)
{
    fmt::memory_buffer text;
    const std::array<double, 4> first = {static_cast<double>(pose), row.pairs > 0 ? 1.0 : 0.0,
                                         static_cast<double>(row.pairs),
                                         static_cast<double>(row.containment)};
    if (!row.nearest) {
        append_row(text, format, first);
        return fmt::to_string(text);
    }
    const MeshDistance& nearest = *row.nearest;
    append_row(text, format,
               std::array<double, 13>{first[0], first[1], first[2], first[3], nearest.distance,
                                      nearest.point_a.x(), nearest.point_a.y(), nearest.point_a.z(),
                                      nearest.point_b.x(), nearest.point_b.y(), nearest.point_b.z(),
                                      static_cast<double>(to_index(nearest.triangle_a)),
                                      static_cast<double>(to_index(nearest.triangle_b))});
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
