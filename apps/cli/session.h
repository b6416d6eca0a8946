// What every subcommand has: the common options, progress that Ctrl-C stops, and where output goes.
#pragma once

#include "cli/progress_bar.h"
#include "proxima/base/parallel.h"
#include "proxima/base/progress.h"
#include "proxima/base/result.h"
#include "proxima/mesh/triangle_mesh.h"

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace proxima {

/// Options of every subcommand.
struct CommonOptions {
    std::string json;   ///< file for the JSON result, "-" for stdout, empty for none
    int threads = 0;    ///< 0 = all that the machine offers
    bool quiet = false; ///< nothing for people, neither text nor a progress bar
};

/// One run of a subcommand.
class Session {
public:
    explicit Session(CommonOptions options) : options_(std::move(options)) {}

    [[nodiscard]] const CommonOptions& options() const noexcept { return options_; }
    [[nodiscard]] Threads threads() const noexcept { return {options_.threads}; }
    [[nodiscard]] Progress& progress() noexcept { return progress_; }

    /// Whether to show a progress bar.
    [[nodiscard]] BarMode bar() const noexcept
    {
        return options_.quiet ? BarMode::off : BarMode::automatic;
    }

    /// Writes text for people to stdout, unless they want none or stdout is for JSON.
    void print(std::string_view text) const;

    /// Writes the result where --json says; nothing without it.
    [[nodiscard]] Status write_json(const nlohmann::ordered_json& result) const;

    /// Error file_not_writable where stdout did not take everything: to be asked last.
    [[nodiscard]] Status finish() const;

    /// The mesh of a built-in name or a file.
    [[nodiscard]] Result<TriangleMesh> load_model(const std::string& model);

    /// Error cancelled once somebody asked to stop: to be asked between steps.
    [[nodiscard]] Status check_running() const;

    /// Error file_not_writable where `path` could not be written: to be asked before long work, so
    /// that a wrong folder does not cost its result. "" and "-" are fine.
    [[nodiscard]] static Status check_writable(const std::string& path);

private:
    CommonOptions options_;
    Progress progress_;
};

} // namespace proxima
