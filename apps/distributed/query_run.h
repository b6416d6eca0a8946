// What closest, rays and sign have in common: a table comes in on rank 0, all ranks answer it block by
// block, and rank 0 writes the answers in its order.
//
// A query has
//     Answer, what, form                what messages carry; "points"; the columns of its table
//     check_row(table, row)             on rank 0
//     has_winding_if_open               see PartOptions
//     answer(part, rows, world)         of this rank's rows. Collective
//     header, append                    texts of the answers
//     oracle(model), verify(oracle, part, rows, answers)    on rank 0: the library's own answers
#pragma once

#include "base/progress.h"
#include "distributed/mesh_input.h"
#include "distributed/mesh_part.h"
#include "distributed/query_command.h"
#include "distributed/query_report.h"
#include "distributed/row_output.h"
#include "distributed/table_blocks.h"

#include <fmt/format.h>
#include <optional>

namespace proxima {

template <class Query>
class QueryRun {
public:
    using Answer = typename Query::Answer;

    QueryRun(const QueryOptions& options, World& world) : options_(options), world_(world) {}

    Status run()
    {
        const double start = MPI_Wtime();
        auto output = RowOutput::open(options_.out, world_);
        if (!output) return tl::unexpected(output.error());
        auto table = TableBlocks::open(options_.table, Query::form, &Query::check_row, world_);
        if (!table) return tl::unexpected(table.error());
        auto slice = load_slice(options_.model, options_.triangles, world_);
        if (!slice) return tl::unexpected(slice.error());
        const auto part = make_mesh_part(std::move(*slice),
                                         {.routing_depth = options_.routing_depth,
                                          .has_winding_if_open = Query::has_winding_if_open},
                                         world_);
        if (!part) return tl::unexpected(part.error());
        QueryTimes times;
        times.build_seconds = MPI_Wtime() - start;
        times.build_bytes = world_.sent_bytes();
        if (Status status = open_oracle(); !status) return status;
        Status status = output->write_header(
            [&](AnswerFormat format) { return Query::header(format, table->rows()); });
        if (!status) return status;
        begin_stage(&world_.progress(), "answering", table->rows());
        while (true) {
            const auto block = table->next(world_);
            if (!block) return tl::unexpected(block.error());
            if (!*block) break;
            const double begin = MPI_Wtime();
            auto answers = Query::answer(*part, (*block)->own, world_);
            if (!answers) return tl::unexpected(answers.error());
            times.answer_seconds += MPI_Wtime() - begin;
            status = write(*output, *part, (*block)->own.first, *answers);
            if (status) status = verify(*part, (*block)->all, std::move(*answers));
            if (!status) return status;
            advance_stage(&world_.progress(), (*block)->all.size());
        }
        status = output->commit();
        if (!status) return status;
        report_queries(options_, *part, table->rows(), Query::what, times, world_);
        return {};
    }

private:
    Status write(RowOutput& output, const MeshPart& part, std::uint64_t first,
                 const std::vector<Answer>& answers)
    {
        return output.write([&](AnswerFormat format) {
            fmt::memory_buffer text;
            for (std::size_t i = 0; i < answers.size(); ++i)
                Query::append(part, first + i, answers[i], format, text);
            return text;
        });
    }

    Status open_oracle()
    {
        if (!options_.is_verified) return {};
        return world_.agree_on([&]() -> Status {
            if (world_.rank() != 0) return {};
            auto index = Query::oracle(options_.model);
            if (!index) return tl::unexpected(index.error());
            oracle_ = *index;
            return {};
        });
    }

    Status verify(const MeshPart& part, const TableRows& rows, std::vector<Answer> answers)
    {
        if (!options_.is_verified) return {};
        const auto all = world_.collect(std::move(answers));
        if (!all) return tl::unexpected(all.error());
        return world_.agree_on([&]() -> Status {
            return world_.rank() == 0 ? Query::verify(oracle_, part, rows, all->items) : Status{};
        });
    }

    const QueryOptions& options_;
    World& world_;
    MeshIndex oracle_; ///< on rank 0, with --verify
};

} // namespace proxima
