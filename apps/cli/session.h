// What every subcommand has: the common options, progress that Ctrl-C stops, and where output goes.
#pragma once

#include "base/output_file.h"
#include "cli/number_table.h"
#include "cli/progress_bar.h"
#include "proxima/execution.h"
#include "proxima/mesh_io.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <vector>

namespace proxima {

/// As the name of an output: stdout.
inline constexpr const char* to_stdout = "-";

/// Options of every subcommand.
struct CommonOptions {
    std::string json;              ///< file for the JSON result, "-" for stdout, empty for none
    std::optional<int> threads;    ///< 0 = all that the machine offers; none where not asked for
    bool quiet = false;            ///< nothing for people, neither text nor a progress bar
    bool progress = false;         ///< progress also where stderr is no terminal
    bool points_and_lines = false; ///< of files, as triangles without area
    std::string simd;              ///< the instruction set of kernels, empty for the best
    std::vector<std::string> arguments; ///< values of all options, as given: input files among them
    std::vector<std::string> outputs;   ///< those of them that name a file to write
};

/// Error file_not_writable where stdout did not take everything: to be asked last.
[[nodiscard]] Status finish_stdout();

/// One run of a subcommand.
class Session {
public:
    explicit Session(CommonOptions options) : options_(std::move(options)) {}

    [[nodiscard]] const CommonOptions& options() const noexcept { return options_; }

    /// As --threads says, all without it.
    [[nodiscard]] Threads threads() const noexcept { return {options_.threads.value_or(0)}; }
    /// The threads and progress of a command, for the options of what it calls.
    [[nodiscard]] Execution execution() noexcept
    {
        return {.threads = threads(), .progress = &progress()};
    }

    /// As --threads says, one without it: for measurements, which others must be able to repeat.
    [[nodiscard]] Threads threads_to_measure() const noexcept
    {
        return {options_.threads.value_or(1)};
    }
    [[nodiscard]] Progress& progress() noexcept { return progress_; }

    /// What is read of a model's file, as --points-and-lines says.
    [[nodiscard]] Primitives primitives() const noexcept
    {
        return options_.points_and_lines ? Primitives::points_and_lines : Primitives::triangles;
    }

    /// Whether to show a progress bar.
    [[nodiscard]] BarMode bar() const noexcept
    {
        return options_.progress ? BarMode::lines
               : options_.quiet  ? BarMode::off
                                 : BarMode::automatic;
    }

    /// Writes text for people to stdout, unless they want none or stdout is for JSON. What a
    /// terminal cannot show is written as \xNN, in names of files line feeds too.
    void print(std::string_view text) const;

    /// A line for people, unless they want none, on what was decided for them. The command ends with
    /// it, on stderr.
    void note(std::string_view line);
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

    /// Writes the result where --json says; nothing without it.
    [[nodiscard]] Status write_json(const nlohmann::ordered_json& result) const;

    /// The mesh of a built-in name or a file.
    [[nodiscard]] Result<TriangleMesh> load_model(const std::string& model);

    /// Whether a model's file had vertices and no triangles, and only triangles were asked for.
    [[nodiscard]] bool found_only_points() const noexcept { return found_only_points_; }

    /// The table of a file, with its note. Errors as read_number_table.
    [[nodiscard]] Result<NumberTable> load_table(const std::string& path, const TableForm& form);

    /// Error cancelled once somebody asked to stop: to be asked between steps.
    [[nodiscard]] Status check_running() const;

    /// What would go wrong with writing to --json and to `files`: to be asked before long work, so
    /// that a wrong folder does not cost its result. Empty names are left out. Errors:
    /// invalid_argument (two outputs that are one file, a file that another argument names as well,
    /// stdout for other than --json, or the file that stdout goes to while there is something to be
    /// written there: the report, JSON, or, with `rows_on_stdout`, rows of answers),
    /// file_not_writable, cancelled. A pipe is kept open from here on, as its reader would take
    /// closing it for the end of the output.
    [[nodiscard]] Status check_outputs(const std::vector<std::string>& files,
                                       bool rows_on_stdout = false);

    /// Those files that check_outputs() was asked about and that have been written since.
    [[nodiscard]] std::vector<std::string> written() const;

private:
    /// A regular file, or none, as it was.
    struct OutputBefore {
        std::string path;
        struct stat status; ///< all zero where there was none
    };

    [[nodiscard]] Status check_inputs(const std::vector<std::string>& outputs) const;

    CommonOptions options_;
    Progress progress_;
    bool found_only_points_ = false;
    std::vector<std::string> notes_;
    std::vector<OutputFile> outputs_;  ///< those that are no regular files
    std::vector<OutputBefore> before_; ///< the others
};

} // namespace proxima
