#include "cli/intersection_files.h"

#include "cli/npy_header.h"
#include "cli/row_text.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <iterator>
#include <vector>

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

std::string pose_header(AnswerFormat format, PoseColumns columns, std::uint64_t rows)
{
    std::string names = "pose,intersecting,pairs,contained";
    if (columns.distance) names += ",separation,ax,ay,az,bx,by,bz,triangle_a,triangle_b";
    if (columns.cells) names += ",cell_pairs,cells_a,cells_b,cell_triangles_a,cell_triangles_b";
    if (format == AnswerFormat::csv) return names + '\n';
    return npy_header(rows, 1 + static_cast<std::size_t>(std::ranges::count(names, ',')));
}

std::string pose_row(AnswerFormat format, std::uint64_t pose, const PoseRow& row)
{
    std::vector<double> numbers = {static_cast<double>(pose), row.pairs > 0 ? 1.0 : 0.0,
                                   static_cast<double>(row.pairs),
                                   static_cast<double>(row.containment)};
    if (row.nearest) {
        const MeshDistance& nearest = *row.nearest;
        numbers.push_back(nearest.distance);
        for (const Vec3& point : {nearest.point_a, nearest.point_b})
            numbers.insert(numbers.end(), point.begin(), point.end());
        for (const TriangleId id : {nearest.triangle_a, nearest.triangle_b})
            numbers.push_back(static_cast<double>(to_index(id)));
    }
    if (row.cells) {
        const MeetingCells& cells = *row.cells;
        for (const std::uint64_t count :
             {cells.pairs, cells.of_a, cells.of_b, cells.triangles_of_a, cells.triangles_of_b})
            numbers.push_back(static_cast<double>(count));
    }
    fmt::memory_buffer text;
    append_row(text, format, numbers);
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
