#include "cli/session.h"

#include "proxima/base/output_file.h"
#include "proxima/base/text.h"
#include "proxima/mesh/mesh_io.h"
#include "proxima/mesh/sample_meshes.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

namespace proxima {

namespace {

/// One text for all names of a file, whether it exists or not.
std::string true_path(const std::string& path)
{
    std::error_code error;
    const auto whole =
        std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
    return error ? path : whole.string();
}

} // namespace

void Session::print(std::string_view text) const
{
    if (options_.quiet || options_.json == to_stdout) return;
    std::fwrite(text.data(), 1, text.size(), stdout); // finish() asks whether it arrived
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

Status Session::finish() const
{
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
    return fail(ErrorCode::file_not_writable,
                concat("cannot write: ", std::strerror(errno), "; the output is incomplete"),
                "standard output");
}

Result<TriangleMesh> Session::load_model(const std::string& model)
{
    const ProgressBar shown(progress_, bar());
    if (is_sample_mesh_name(model)) return sample_mesh(model, {.progress = &progress_});
    return read_mesh(model, {.progress = &progress_});
}

Status Session::check_running() const
{
    if (!progress_.cancelled()) return {};
    return fail(ErrorCode::cancelled, "stopped on request; nothing more was written");
}

Status Session::check_outputs(const std::vector<std::string>& files) const
{
    std::vector<std::string> seen;
    const auto check = [&](const std::string& path) -> Status {
        if (path.empty()) return {};
        const std::string file = true_path(path);
        if (std::ranges::find(seen, file) != seen.end()) {
            return fail(ErrorCode::invalid_argument,
                        "two outputs would go to this file: give each a name of its own", path);
        }
        seen.push_back(file);
        auto output = OutputFile::create(path); // thrown away uncommitted
        return output ? Status{} : tl::unexpected(output.error());
    };
    for (const std::string& path : files) {
        if (path == to_stdout) {
            return fail(ErrorCode::invalid_argument,
                        "only --json can write to stdout: name a file (./- for one called -)",
                        path);
        }
        if (auto status = check(path); !status) return status;
    }
    return options_.json == to_stdout ? Status{} : check(options_.json);
}

} // namespace proxima
