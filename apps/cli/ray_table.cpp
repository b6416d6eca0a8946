#include "cli/ray_table.h"

#include "cli/npy_header.h"
#include "cli/row_text.h"

#include <array>
#include <fmt/format.h>
#include <limits>

namespace proxima {

namespace {

constexpr std::string_view hit_columns = "index,t,triangle,u,v";
constexpr std::string_view cell_columns = "ray,cell_depth,cx,cy,cz,enter,exit,chord,penetration";

std::string header(AnswerFormat format, std::string_view columns, std::uint64_t count,
                   std::uint64_t rows)
{
    return format == AnswerFormat::npy ? npy_header(rows, count) : fmt::format("{}\n", columns);
}

} // namespace

std::string hit_header(AnswerFormat format, std::uint64_t rows)
{
    return header(format, hit_columns, 5, rows);
}

std::string cell_header(AnswerFormat format, std::uint64_t rows)
{
    return header(format, cell_columns, 9, rows);
}

std::string hit_rows(AnswerFormat format, std::uint64_t first,
                     std::span<const std::optional<RayHit>> hits)
{
    fmt::memory_buffer text;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        std::array<double, 5> row = {static_cast<double>(first + i),
                                     std::numeric_limits<double>::infinity(), -1, 0, 0};
        if (hits[i]) {
            row = {row[0], hits[i]->t, static_cast<double>(to_index(hits[i]->triangle)), hits[i]->u,
                   hits[i]->v};
        }
        append_row(text, format, row);
    }
    return fmt::to_string(text);
}

std::string cell_rows(AnswerFormat format, std::uint64_t ray, std::span<const CellOnRay> cells)
{
    fmt::memory_buffer text;
    for (const CellOnRay& at : cells) {
        const auto coordinates = cell_coordinates(at.cell.key);
        append_row(text, format,
                   std::array<double, 9>{
                       static_cast<double>(ray), static_cast<double>(depth(at.cell.key)),
                       static_cast<double>(coordinates[0]), static_cast<double>(coordinates[1]),
                       static_cast<double>(coordinates[2]), at.enter, at.exit, at.chord,
                       at.penetration});
    }
    return fmt::to_string(text);
}

} // namespace proxima
