#include "cli/command_line.h"

#include "base/simd.h"
#include "cli/interrupt.h"
#include "cli/names.h"
#include "cli/number_checks.h"
#include "cli/printable.h"
#include "cli/read_model.h"
#include "cli/session.h"
#include "cli/stderr_text.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <fmt/format.h>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace proxima {

namespace {

constexpr int bad_input = 1;
constexpr int wrong_usage = 2;
constexpr int first_signal_status = 128;

/// Those that name a file which Session::check_outputs is told of, of all commands.
constexpr std::array<std::string_view, 13> output_options = {
    "--json",   "--out",        "--picture", "--save",      "--pairs",        "--contour", "--map",
    "--record", "--vertex-map", "--ticks",   "--histogram", "--budget-curve", "--state"};

/// Text that goes to stderr in pieces, without allocating.
class StderrLine {
public:
    StderrLine() noexcept = default;
    StderrLine(const StderrLine&) = delete;
    StderrLine& operator=(const StderrLine&) = delete;
    ~StderrLine() { flush(); }

    void add(std::string_view text) noexcept
    {
        if (text.size() > text_.size() - used_) flush();
        if (text.size() > text_.size()) return write_stderr(text);
        used_ += text.copy(text_.data() + used_, text.size());
    }

private:
    void flush() noexcept
    {
        write_stderr({text_.data(), used_});
        used_ = 0;
    }

    std::array<char, 4096> text_{};
    std::size_t used_ = 0;
};

/// Prints "proxima: message" as one line. Messages may quote what a damaged file holds: what is no
/// printable text of a terminal is shown as \xNN.
void report(std::string_view message) noexcept
{
    StderrLine line;
    line.add("proxima: ");
    for_each_printable(message, [&](std::string_view piece) {
        line.add(piece == escaped_line_feed ? " " : piece);
    });
    line.add("\n");
}

constexpr std::string_view out_of_memory =
    "out of memory: give it more, a smaller task, or, where there is one, a --budget-mb or "
    "--lists-mb that this machine has";

/// Functions of the argument parser that promise to throw nothing allocate.
[[noreturn]] void end_without_memory()
{
    try {
        if (const std::exception_ptr thrown = std::current_exception())
            std::rethrow_exception(thrown);
    } catch (const std::bad_alloc&) {
        report(out_of_memory);
        ::_exit(bad_input);
    } catch (...) {
        std::abort();
    }
    std::abort();
}

void add_common_options(CLI::App& parser, CommonOptions& options)
{
    parser.add_option("--json", options.json, "Write the result as JSON to FILE, or to stdout: -")
        ->type_name("FILE");
    parser.add_option("--threads", options.threads, "Threads to use; 0 for all")
        ->check(CLI::Range(0, 1024))
        ->type_name("N");
    parser
        .add_option("--simd", options.simd,
                    "Instruction set of kernels, such as AVX2, instead of the best")
        ->transform([](std::string name) {
            for (char& letter : name)
                letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
            return name;
        })
        ->envname("PROXIMA_SIMD")
        ->type_name("NAME");
    parser.add_flag("--points-and-lines", options.points_and_lines,
                    "Read points and lines of model files, too, as triangles without area");
    parser.add_flag("--quiet", options.quiet,
                    "Print no report, notes or progress, but for --progress");
    parser.add_flag("--progress", options.progress,
                    "Show progress on stderr also in a pipe, a line per stage");
}

/// What an error says, with what somebody can do here, for not every command has a budget, and with what
/// was done all the same.
std::string advice_of(const Error& error, const CLI::App& parser, const Session& session)
{
    constexpr std::string_view raise = "raise the budget";
    std::string text = describe(error);
    const std::size_t at = text.rfind(raise);
    if (error.code == ErrorCode::budget_exceeded && at != std::string::npos) {
        text.replace(at, raise.size(),
                     parser.get_option_no_throw("--budget-mb") != nullptr
                         ? "raise --budget-mb"
                         : "give it more memory (ulimit -v, where that is the limit)");
    }
    if (error.code == ErrorCode::invalid_mesh && session.found_only_points()) text += points_hint;
    if (const auto written = session.written(); !written.empty())
        text += fmt::format("; before that, {} had been written", fmt::join(written, ", "));
    return text;
}

/// "; did you mean --depth?", where a word is close to what was typed.
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words)
{
    const std::string word = similar_word(typed, words);
    return word.empty() ? std::string() : fmt::format("; did you mean {}?", word);
}

/// A suggestion for the first option that the command does not have.
std::string suggest_option(const CLI::App& parser)
{
    std::vector<std::string> names;
    for (const CLI::Option* const option : parser.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& typed : parser.remaining())
        if (typed.starts_with("-")) return did_you_mean(typed.substr(0, typed.find('=')), names);
    return {};
}

void read_whole_numbers_as_decimal(CLI::App& parser)
{
    for (CLI::Option* const option : parser.get_options({})) {
        const std::string type = option->get_type_name(); // such as N or N:INT in [0 - 19]
        if (type == "N" || type.starts_with("N:")) option->transform(decimal());
    }
}

/// The first argument that is empty, or a value after "=" that is, described; else nothing. A variable
/// of a shell that is not set makes one, and it would be as if the option were not there.
std::string describe_empty(std::span<char* const> arguments)
{
    for (std::size_t i = 1; i < arguments.size(); ++i) {
        const std::string_view argument = arguments[i];
        if (argument.starts_with("--") && argument.find('=') == argument.size() - 1)
            return fmt::format("{} has an empty value", argument);
        if (argument.empty()) {
            return fmt::format("the argument after {} is empty",
                               i > 1 ? arguments[i - 1] : "proxima");
        }
    }
    return {};
}

int run(const Command& command, const CommonOptions& options)
{
    Session session(options);
    const InterruptGuard guard(session.progress());
    Status status;
    if (!options.simd.empty()) {
        status = choose_simd_target(options.simd);
        if (!status) status.error().where = "--simd (or PROXIMA_SIMD)";
    }
    if (status) status = session.check_outputs({});
    if (status) status = command.run(session);
    if (status) status = finish_stdout();
    if (status) {
        for (const std::string& note : session.notes()) report(note);
        return 0;
    }
    report(advice_of(status.error(), *command.parser, session));
    const int signal = InterruptGuard::signal_number();
    return status.error().code == ErrorCode::cancelled && signal != 0 ? first_signal_status + signal
                                                                      : bad_input;
}

int print_help_or_version(const CLI::App& app, const CLI::ParseError& error)
{
    const int code = app.exit(error);
    const Status status = finish_stdout();
    if (status) return code;
    report(describe(status.error()));
    return bad_input;
}

/// "help closest" becomes "closest --help", and "help" alone or twice "--help".
void turn_help_into_an_option(std::vector<const char*>& arguments,
                              const std::vector<std::string>& commands)
{
    const auto first_is_help = [&] {
        return arguments.size() > 1 && std::string_view(arguments[1]) == "help";
    };
    if (!first_is_help()) return;
    while (first_is_help()) arguments.erase(arguments.begin() + 1);
    if (arguments.size() == 1 || std::ranges::find(commands, arguments[1]) != commands.end())
        arguments.push_back("--help");
}

/// What is wrong with the arguments of a command, and where to read about it.
std::string describe_usage(const CLI::ParseError& error, const CLI::App& command)
{
    return fmt::format("{}{}; see proxima {} --help", error.what(), suggest_option(command),
                       command.get_name());
}

/// What is wrong with arguments that do not begin with the name of a command.
std::string describe_usage(const CLI::ParseError& error, const std::vector<const char*>& arguments,
                           const std::vector<std::string>& commands)
{
    if (arguments.size() > 1 && arguments[1][0] != '-') {
        return fmt::format("{} is no command: they are {}{}; see proxima --help", arguments[1],
                           fmt::join(commands, ", "), did_you_mean(arguments[1], commands));
    }
    return fmt::format("{}; see proxima --help", error.what());
}

int parse_and_run(int argc, char** argv, const char* version, std::span<const AddCommand> adders)
{
    CLI::App app(
        "Spatial queries on triangle meshes: closest features, rays, contact, culling, touch.",
        "proxima");
    app.set_version_flag("--version", [version] {
        std::string text = fmt::format("{}\ninstruction sets here, the best first:", version);
        for (const SimdTarget& target : simd_targets()) text += ' ' + target.name;
        return text;
    });
    app.require_subcommand(1);
    app.get_formatter()->column_width(32);
    CommonOptions options;
    std::vector<Command> commands;
    for (const AddCommand add : adders) commands.push_back(add(app));
    // After them, for they would take it over.
    app.footer("proxima help SUBCOMMAND says what it does and takes.");
    for (const Command& command : commands) {
        add_common_options(*command.parser, options);
        read_whole_numbers_as_decimal(*command.parser);
    }
    if (const std::string empty = describe_empty({argv, static_cast<std::size_t>(argc)});
        !empty.empty()) {
        report(empty + ": leave the option out, or give it a value");
        return wrong_usage;
    }
    std::vector<std::string> names;
    names.reserve(commands.size());
    for (const Command& command : commands) names.push_back(command.parser->get_name());
    std::vector<const char*> arguments(argv, argv + argc);
    turn_help_into_an_option(arguments, names);
    const auto asked_for = [](const Command& command) { return command.parser->parsed(); };
    try {
        app.parse(static_cast<int>(arguments.size()), arguments.data());
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return print_help_or_version(app, error);
        const auto found = std::ranges::find_if(commands, asked_for);
        report(found != commands.end() ? describe_usage(error, *found->parser)
                                       : describe_usage(error, arguments, names));
        return wrong_usage;
    }
    const Command& command = *std::ranges::find_if(commands, asked_for);
    for (const CLI::Option* const option : command.parser->get_options()) {
        const auto& values = option->results();
        options.arguments.insert(options.arguments.end(), values.begin(), values.end());
        if (std::ranges::find(output_options, option->get_name()) != output_options.end())
            options.outputs.insert(options.outputs.end(), values.begin(), values.end());
    }
    return run(command, options);
}

} // namespace

int run_command_line(int argc, char** argv, const char* version,
                     std::span<const AddCommand> commands)
{
    std::set_terminate(end_without_memory);
    try {
        return parse_and_run(argc, argv, version, commands);
    } catch (const std::bad_alloc&) {
        report(out_of_memory);
    } catch (const std::exception& error) {
        report(error.what());
    }
    return bad_input;
}

} // namespace proxima
