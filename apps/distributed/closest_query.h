// proxima-mpi closest: points, and the closest feature of each.
#pragma once

#include "cli/answer_table.h"
#include "cli/number_table.h"
#include "distributed/closest_over_ranks.h"
#include "distributed/oracle.h"
#include "distributed/table_blocks.h"
#include "proxima/mesh_index.h"

#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

inline constexpr std::array<std::string_view, 1> point_layouts = {"x,y,z"};

/// \pre rows of x,y,z
[[nodiscard]] std::vector<Vec3> points_of(const TableRows& rows);

[[nodiscard]] AnswerRow row_of(const MeshPart& part, std::uint64_t index,
                               const ClosestOfWhole& answer);

/// What of an answer differs from the library's; empty where nothing does.
[[nodiscard]] std::string_view difference(const ClosestOfWhole& answer,
                                          const ClosestFeature& expected, double scale);

/// A query of query_run.h.
struct ClosestQuery {
    using Answer = ClosestOfWhole;
    static constexpr std::string_view what = "points";
    static constexpr TableForm form = {point_layouts};
    static constexpr bool has_winding_if_open = false;

    static Status check_row(const NumberTable& /*table*/, std::size_t /*row*/) { return {}; }
    static std::string header(AnswerFormat format, std::uint64_t rows)
    {
        return answer_header(format, AnswerSigns::absent, rows);
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
