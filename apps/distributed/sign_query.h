// proxima-mpi sign: points, and the closest feature and signed distance of each.
#pragma once

#include "distributed/closest_query.h"
#include "distributed/signs_over_ranks.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// A query of query_run.h.
struct SignQuery {
    using Answer = SignedOfWhole;
    static constexpr std::string_view what = "points";
    static constexpr TableForm form = {point_layouts};
    static constexpr bool has_winding_if_open = true;

    static Status check_row(const NumberTable& /*table*/, std::size_t /*row*/) { return {}; }
    static std::string header(AnswerFormat format, std::uint64_t rows)
    {
        return answer_header(format, AnswerSigns::present, rows);
    }
    static Result<std::vector<Answer>> answer(const MeshPart& part, const TableRows& rows,
                                              World& world)
    {
        return signs_over_ranks(part, points_of(rows), rows.first, world);
    }
    static void append(const MeshPart& part, std::uint64_t index, const Answer& answer,
                       AnswerFormat format, fmt::memory_buffer& text);

    /// The library may find a sign by another method.
    static Result<MeshIndex> oracle(const std::string& model);
    static Status verify(const MeshIndex& oracle, const MeshPart& part, const TableRows& rows,
                         std::span<const Answer> answers);
};

} // namespace proxima
