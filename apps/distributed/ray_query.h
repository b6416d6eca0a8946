// proxima-mpi rays: rays, and the first hit of each.
#pragma once

#include "cli/ray_rows.h"
#include "cli/ray_table.h"
#include "distributed/mesh_part.h"
#include "distributed/oracle.h"
#include "distributed/rays_over_ranks.h"
#include "distributed/table_blocks.h"
#include "proxima/mesh_index.h"

#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// A query of query_run.h.
struct RayQuery {
    using Answer = HitOfWhole;
    static constexpr std::string_view what = "rays";
    static constexpr TableForm form = ray_form;
    static constexpr bool has_winding_if_open = false;

    static Status check_row(const NumberTable& table, std::size_t row)
    {
        return check_ray_row(table, row);
    }
    static std::string header(AnswerFormat format, std::uint64_t rows)
    {
        return hit_header(format, rows);
    }
    static Result<std::vector<Answer>> answer(const MeshPart& part, const TableRows& rows,
                                              World& world);
    static void append(const MeshPart& part, std::uint64_t index, const Answer& answer,
                       AnswerFormat format, fmt::memory_buffer& text);

    static Result<MeshIndex> oracle(const std::string& model) { return index_of_whole(model); }
    static Status verify(const MeshIndex& oracle, const MeshPart& part, const TableRows& rows,
                         std::span<const Answer> answers);
};

} // namespace proxima
