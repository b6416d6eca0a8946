#include "cli/session.h"

#include "base/text.h"
#include "cli/printable.h"
#include "cli/read_model.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace proxima {

namespace {

/// One text for all names of a file, whether it exists or not.
std::string true_path(const std::string& path)
{
    std::error_code error;
    const auto whole = std::filesystem::weakly_canonical(
        std::filesystem::absolute(linked_file(path).value_or(path), error), error);
    return error ? path : whole.string();
}

/// What a file would be read as: "replay:session.pxt" reads session.pxt.
std::string_view without_kind(std::string_view argument)
{
    constexpr std::string_view kind = "replay:";
    if (argument.starts_with(kind)) argument.remove_prefix(kind.size());
    return argument;
}

void make_printable(std::string_view name, std::string& text)
{
    const std::string shown = printable(name);
    if (shown == name) return;
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += shown.size())
        text.replace(at, name.size(), shown);
}

/// A text, which may have lines, with the names in it, with and without their folders, as a terminal
/// can show them in one line.
std::string with_printable_names(std::string text, const std::vector<std::string>& names)
{
    for (const std::string_view name : names) {
        make_printable(name, text);
        make_printable(name.substr(name.rfind('/') + 1), text);
    }
    return text;
}

/// Whether the path leads to the file or the pipe that stdout goes to.
bool is_where_stdout_goes(const std::string& path) noexcept
{
    struct stat there {};
    struct stat out {};
    return ::stat(path.c_str(), &there) == 0 && ::fstat(STDOUT_FILENO, &out) == 0 &&
           there.st_dev == out.st_dev && there.st_ino == out.st_ino &&
           (S_ISREG(out.st_mode) || S_ISFIFO(out.st_mode));
}

/// All zero where there is no such file.
struct stat status_of(const std::string& path) noexcept
{
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) status = {};
    return status;
}

} // namespace

std::vector<std::string> Session::written() const
{
    // A file that is replaced is another one.
    std::vector<std::string> paths;
    for (const OutputBefore& output : before_) {
        const struct stat now = status_of(output.path);
        if (now.st_nlink > 0 &&
            (now.st_dev != output.status.st_dev || now.st_ino != output.status.st_ino))
            paths.push_back(output.path);
    }
    return paths;
}

void Session::print(std::string_view text) const
{
    if (options_.quiet || options_.json == to_stdout) return;
    std::string shown;
    for_each_printable(
        with_printable_names(std::string(text), options_.arguments),
        [&](std::string_view piece) { shown += piece == escaped_line_feed ? "\n" : piece; });
    std::fwrite(shown.data(), 1, shown.size(), stdout); // finish_stdout() asks whether it arrived
}

void Session::note(std::string_view line)
{
    if (!options_.quiet) notes_.emplace_back(line);
}

Status Session::write_json(const nlohmann::ordered_json& result) const
{
    if (options_.json.empty()) return {};
    const std::string text = result.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    if (options_.json == to_stdout) {
        std::fwrite(text.data(), 1, text.size(), stdout);
        std::fputc('\n', stdout);
        return {};
    }
    auto file = OutputFile::create(options_.json);
    if (!file) return tl::unexpected(file.error());
    if (auto status = file->write(text + '\n'); !status) return status;
    return file->commit();
}

Status finish_stdout()
{
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
    return fail(ErrorCode::file_not_writable,
                concat("cannot write: ", std::strerror(errno), "; the output is incomplete"),
                "standard output");
}

Result<TriangleMesh> Session::load_model(const std::string& model)
{
    const ProgressBar shown(progress_, bar());
    auto mesh = read_model(model, primitives(), execution());
    if (mesh && may_be_of_points(model, primitives(), *mesh)) {
        found_only_points_ = true;
        note(concat(model, " has no triangles", points_hint));
    }
    return mesh;
}

Result<NumberTable> Session::load_table(const std::string& path, const TableForm& form)
{
    auto table = read_number_table(path, form, {.execution = {.progress = &progress_}});
    if (table && !table->note.empty()) note(table->note);
    return table;
}

Status Session::check_running() const
{
    if (!progress_.cancelled()) return {};
    return fail(ErrorCode::cancelled, "stopped on request; nothing more was written");
}

Status Session::check_outputs(const std::vector<std::string>& files, bool rows_on_stdout)
{
    const bool uses_stdout = rows_on_stdout || options_.json == to_stdout || !options_.quiet;
    std::vector<std::string> seen;
    const auto check = [&](const std::string& path) -> Status {
        if (path.empty()) return {};
        const std::string file = true_path(path);
        if (std::ranges::find(seen, file) != seen.end()) {
            return fail(ErrorCode::invalid_argument,
                        "two outputs would go to this file: give each a name of its own", path);
        }
        seen.push_back(file);
        if (uses_stdout && is_where_stdout_goes(path)) {
            return fail(ErrorCode::invalid_argument,
                        "stdout goes there, and so does other output: name another file, or, where "
                        "that is the report alone, take --quiet",
                        path);
        }
        auto output = OutputFile::create(path); // thrown away uncommitted
        if (output) {
            if (output->is_direct()) {
                outputs_.push_back(std::move(*output));
            } else if (std::ranges::find(before_, path, &OutputBefore::path) == before_.end()) {
                before_.push_back({path, status_of(path)});
            }
            return {};
        }
        if (auto status = check_running(); !status) return status;
        return tl::unexpected(output.error());
    };
    for (const std::string& path : files) {
        if (path == to_stdout) {
            return fail(ErrorCode::invalid_argument,
                        "only --json can write to stdout: name a file (./- for one called -)",
                        path);
        }
        if (auto status = check(path); !status) return status;
    }
    if (options_.json != to_stdout) {
        if (auto status = check(options_.json); !status) return status;
    }
    return check_inputs(seen);
}

Status Session::check_inputs(const std::vector<std::string>& outputs) const
{
    std::error_code error;
    for (const std::string& output : outputs) {
        if (!std::filesystem::is_regular_file(output, error)) continue;
        const auto is_it = [&](const std::string& argument) {
            const std::string file =
                argument == to_stdout ? "/dev/stdin" : std::string(without_kind(argument));
            return !is_sample_mesh_name(argument) && true_path(file) == output;
        };
        if (std::ranges::count_if(options_.arguments, is_it) ==
            std::ranges::count_if(options_.outputs, is_it))
            continue;
        return fail(ErrorCode::invalid_argument,
                    "would be read and written: name another file for what is written", output);
    }
    return {};
}

} // namespace proxima
