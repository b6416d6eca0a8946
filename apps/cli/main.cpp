// proxima: the library on the command line. One subcommand per file; here is what they share:
// the common options, exit status, and one line on stderr for whatever went wrong.
//
//     0 done    1 a bad input or output    2 wrong usage    130, 143 stopped by a signal
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/names.h"
#include "cli/session.h"
#include "viewer/commands.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <fmt/core.h>
#include <string>
#include <string_view>
#include <vector>

namespace {

using proxima::Command;
using proxima::CommonOptions;
using proxima::ErrorCode;

constexpr int bad_input = 1;
constexpr int wrong_usage = 2;
constexpr int first_signal_status = 128;

/// Prints "proxima: message" as one line. Messages may quote what a damaged file holds: what is no
/// printable text of a terminal is shown as \xNN.
void report(std::string_view message)
{
    std::string line = "proxima: ";
    for (std::size_t place = 0; place < message.size();) {
        const std::size_t length = proxima::utf8_length(message.substr(place));
        if (length > 0) {
            line += message.substr(place, length);
            place += length;
        } else {
            line += message[place] == '\n'
                        ? " "
                        : fmt::format("\\x{:02X}", static_cast<unsigned char>(message[place]));
            ++place;
        }
    }
    fmt::print(stderr, "{}\n", line);
}

void add_common_options(CLI::App& parser, CommonOptions& options)
{
    parser.add_option("--json", options.json, "Write the result as JSON to FILE, or to stdout: -")
        ->type_name("FILE");
    parser.add_option("--threads", options.threads, "Threads to use; 0 for all")
        ->check(CLI::Range(0, 1024))
        ->type_name("N");
    parser.add_flag("--quiet", options.quiet, "Print nothing for people");
}

int run(const Command& command, const CommonOptions& options)
{
    proxima::Session session(options);
    const proxima::InterruptGuard guard(session.progress());
    proxima::Status status = session.check_outputs({});
    if (status) status = command.run(session);
    if (status) status = session.finish();
    if (status) return 0;
    report(describe(status.error()));
    const int signal = proxima::InterruptGuard::signal_number();
    return status.error().code == ErrorCode::cancelled && signal != 0 ? first_signal_status + signal
                                                                      : bad_input;
}

int parse_and_run(int argc, char** argv)
{
    CLI::App app("One octree for every spatial question about a triangle mesh.", "proxima");
    app.set_version_flag("--version", PROXIMA_VERSION);
    app.require_subcommand(1);
    app.get_formatter()->column_width(32);
    CommonOptions options;
    const std::vector<Command> commands = {
        proxima::add_octree_command(app),    proxima::add_compare_command(app),
        proxima::add_minkowski_command(app), proxima::add_proximity_command(app),
        proxima::add_closest_command(app),   proxima::add_patch_command(app),
        proxima::add_raycast_command(app),   proxima::add_cull_command(app),
        proxima::add_intersect_command(app), proxima::add_touch_command(app),
        proxima::add_tables_command(app),    proxima::add_check_command(app),
        proxima::add_figures_command(app),   proxima::add_view_command(app)};
    for (const Command& command : commands) add_common_options(*command.parser, options);
    const auto asked_for = [](const Command& command) { return command.parser->parsed(); };
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error); // help or version
        const auto found = std::ranges::find_if(commands, asked_for);
        if (found == commands.end() && argc > 1 && argv[1][0] != '-') {
            report(fmt::format(
                "{} is no command: they are octree, compare, minkowski, proximity, closest, "
                "patch, raycast, cull, intersect, touch, tables, check, figures and view; see "
                "proxima "
                "--help",
                argv[1]));
            return wrong_usage;
        }
        report(fmt::format("{}; see proxima {}--help", error.what(),
                           found == commands.end() ? "" : found->parser->get_name() + ' '));
        return wrong_usage;
    }
    return run(*std::ranges::find_if(commands, asked_for), options);
}

} // namespace

int main(int argc, char** argv)
{
    try {
        return parse_and_run(argc, argv);
    } catch (const std::bad_alloc&) {
        report("out of memory: give a --budget-mb that this machine has, or a smaller task");
    } catch (const std::exception& error) {
        report(error.what());
    }
    return bad_input;
}
