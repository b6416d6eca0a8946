#include "cli/row_writer.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

namespace proxima {

void add_rows_option(CLI::App& parser, std::string& path)
{
    parser
        .add_option("--out", path,
                    "Write the answers: .csv, .npy, or - for CSV to stdout, where they go without "
                    "--out and --json")
        ->type_name("FILE");
}

std::string rows_path(const std::string& out, const Session& session,
                      const std::vector<std::string>& others)
{
    const bool nothing_else =
        session.options().json.empty() && std::ranges::all_of(others, &std::string::empty);
    return out.empty() && nothing_else ? to_stdout : out;
}

Status check_rows(const std::string& path, Session& session, const std::vector<std::string>& others)
{
    if (!path.empty()) {
        if (const auto format = answer_format(path); !format) return tl::unexpected(format.error());
    }
    return check_outputs_or_stdout(path, session, others);
}

Status check_outputs_or_stdout(const std::string& path, Session& session,
                               const std::vector<std::string>& others)
{
    std::vector<std::string> files = others;
    if (path != to_stdout) files.push_back(path);
    if (path != to_stdout || session.options().json != to_stdout)
        return session.check_outputs(files, path == to_stdout);
    return fail(ErrorCode::invalid_argument,
                "--json and --out would both write to stdout: give one of them a file", to_stdout);
}

Result<RowWriter> RowWriter::open(const std::string& path)
{
    RowWriter writer;
    if (path.empty()) return writer;
    const auto format = answer_format(path);
    if (!format) return tl::unexpected(format.error());
    writer.format_ = *format;
    writer.wanted_ = true;
    if (path == to_stdout) return writer;
    auto file = OutputFile::create(path);
    if (!file) return tl::unexpected(file.error());
    writer.file_.emplace(std::move(*file));
    return writer;
}

Status RowWriter::write(std::string_view text)
{
    if (!wanted_) return {};
    if (file_) return file_->write(text);
    std::fwrite(text.data(), 1, text.size(), stdout);
    return {};
}

} // namespace proxima
