// Where the rows of answers go: a file that appears when it is whole, stdout, or nowhere.
#pragma once

#include "base/output_file.h"
#include "base/parallel.h"
#include "cli/answer_table.h"
#include "cli/session.h"
#include "proxima/result.h"

#include <CLI/App.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

/// --out, the file of a command's answers.
void add_rows_option(CLI::App& parser, std::string& path);

/// Where rows go: as --out says, else to stdout, unless --json or one of `others`, which are paths
/// or empty, was asked for instead.
[[nodiscard]] std::string rows_path(const std::string& out, const Session& session,
                                    const std::vector<std::string>& others = {});

/// What would go wrong with rows to `path`: to be asked before long work. Errors: those of
/// answer_format and Session::check_outputs; invalid_argument where --json goes to stdout too.
[[nodiscard]] Status check_rows(const std::string& path, Session& session,
                                const std::vector<std::string>& others = {});

/// What would go wrong with outputs of which the first may be stdout. Errors: those of
/// Session::check_outputs; invalid_argument where --json goes to stdout too.
[[nodiscard]] Status check_outputs_or_stdout(const std::string& path, Session& session,
                                             const std::vector<std::string>& others = {});

class RowWriter {
public:
    /// "-" is stdout, "" nowhere. Errors: those of answer_format, file_not_writable.
    [[nodiscard]] static Result<RowWriter> open(const std::string& path);

    [[nodiscard]] bool is_wanted() const noexcept { return wanted_; }
    [[nodiscard]] AnswerFormat format() const noexcept { return format_; }

    /// Nothing where no rows are wanted. What stdout did not take, finish_stdout says.
    [[nodiscard]] Status write(std::string_view text);

    /// Writes the texts of `count` items in order, after threads have made them: make(first, end)
    /// returns that of a chunk.
    template <class Make>
    [[nodiscard]] Status write_chunks(std::size_t count, std::size_t chunk, Threads threads,
                                      const Make& make)
    {
        if (!wanted_) return {};
        std::vector<std::string> texts(chunk_count(count, chunk));
        parallel_chunks(count, chunk, threads, [&](std::size_t first, std::size_t end) {
            texts[first / chunk] = make(first, end);
        });
        for (const std::string& text : texts)
            if (Status status = write(text); !status) return status;
        return {};
    }

    [[nodiscard]] Status commit() { return file_ ? file_->commit() : Status{}; }

private:
    bool wanted_ = false;
    AnswerFormat format_ = AnswerFormat::csv;
    std::optional<OutputFile> file_;
};

} // namespace proxima
