// proxima-mpi: octrees of meshes that are spread over the processes of a run, and queries. Run it by
// mpirun.
// This program links p4est, which is under the GPL.
#include "base/hash.h"
#include "cli/interrupt.h"
#include "cli/progress_bar.h"
#include "distributed/octree_command.h"
#include "distributed/query_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <malloc.h>
#include <map>
#include <new>
#include <optional>
#include <p4est_base.h>
#include <span>
#include <string>

namespace proxima {

namespace {

constexpr int first_signal_status = 128;

using RunCommand = std::function<Status(World&)>;
using AddCommand = RunCommand (*)(CLI::App& app);

/// Ranks that do different things would wait for each other for ever.
Status check_arguments(std::span<char* const> words, const World& world)
{
    std::string text;
    for (const char* const word : words) {
        text += '\0'; // words may have spaces
        text += word;
    }
    Status status;
    if (const std::uint64_t hash = hash_bytes(std::as_bytes(std::span(text)), 0);
        world.from_first(hash) != hash) {
        std::ranges::replace(text, '\0', ' ');
        status = fail(ErrorCode::invalid_argument,
                      concat("rank ", world.rank(), " has other arguments than rank 0,", text,
                             ": give all ranks the same, names of files, too"));
    }
    return world.agree(status);
}

/// The arguments, and the command that they name.
struct CommandLine {
    CLI::App app{"Octrees of triangle meshes, and queries, over several processes"};
    std::map<std::string, RunCommand> commands;
    bool shows_progress = false;
    double wait_seconds = 30;
    std::optional<CLI::ParseError> error;

    CommandLine(int argc, char** argv)
    {
        constexpr AddCommand add_commands[] = {add_octree_command, add_closest_command,
                                               add_rays_command, add_sign_command};
        app.set_version_flag("--version", "proxima-mpi " PROXIMA_VERSION);
        app.require_subcommand(1);
        app.fallthrough(); // of the subcommands below
        app.add_flag("--progress", shows_progress, "Show the first process's progress on stderr");
        app.add_option("--wait", wait_seconds,
                       "Seconds in which all processes must reach each other at the start (default "
                       "30)")
            ->check([](const std::string& text) {
                const double seconds = std::strtod(text.c_str(), nullptr);
                return seconds >= 0.1 && seconds <= 1e6 ? "" : "must be 0.1 to 1000000 seconds";
            });
        for (const AddCommand add_command : add_commands) {
            RunCommand command = add_command(app);
            commands[app.get_subcommands({}).back()->get_name()] = std::move(command);
        }
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& wrong) {
            error = wrong;
        }
    }
};

/// Runs the command that the arguments name. Returns the exit status, the same on all ranks. Only
/// rank 0 prints.
int run(CommandLine& line, std::span<char* const> words, World& world)
{
    if (const Status same = check_arguments(words, world); !same) {
        if (world.rank() == 0) {
            std::fprintf(stderr, "proxima-mpi: %s\n", describe(same.error()).c_str());
        }
        return 2;
    }
    if (line.error) {
        const bool is_help = line.error->get_exit_code() == 0;
        if (world.rank() == 0) line.app.exit(*line.error);
        return is_help ? 0 : 2;
    }
    const InterruptGuard guard(world.progress());
    Status status;
    {
        const bool is_shown = world.rank() == 0 && line.shows_progress;
        const ProgressBar bar(world.progress(), is_shown ? BarMode::lines : BarMode::off);
        status = line.commands.at(line.app.get_subcommands().front()->get_name())(world);
    }
    if (status) return 0;
    if (world.rank() == 0) {
        std::fprintf(stderr, "proxima-mpi: %s\n", describe(status.error()).c_str());
    }
    const auto signal = static_cast<std::uint64_t>(InterruptGuard::signal_number());
    const int stopped_by = static_cast<int>(world.max(signal));
    return status.error().code == ErrorCode::cancelled && stopped_by != 0
               ? first_signal_status + stopped_by
               : 1;
}

/// Ends all ranks, with a line of this rank: the others wait for it, and it cannot tell them. Needs
/// no memory.
[[noreturn]] void stop_all(const char* why)
{
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    std::fprintf(stderr, "proxima-mpi: rank %d stopped: %s\n", rank, why);
    MPI_Abort(MPI_COMM_WORLD, 1);
    std::abort();
}

void stop_at_mpi_error(MPI_Comm*, int* code, ...)
{
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(*code, text, &length);
    stop_all(text);
}

/// What MPI cannot do ends all ranks with a line of this program.
void name_errors_of_mpi()
{
    MPI_Errhandler handler = MPI_ERRHANDLER_NULL;
    MPI_Comm_create_errhandler(stop_at_mpi_error, &handler);
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, handler);
    MPI_Errhandler_free(&handler); // the communicator keeps it
}

/// Arrays of a rank's triangles are made, sent and dropped one after the other: the system need not
/// clear the memory of those below 32 MB for each again.
void keep_freed_memory()
{
#ifdef __GLIBC__
    constexpr int kept_bytes = 32 << 20;
    mallopt(M_MMAP_THRESHOLD, kept_bytes);
    mallopt(M_TRIM_THRESHOLD, 2 * kept_bytes);
#endif
}

void start_p4est()
{
    sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_ERROR);
    sc_set_abort_handler([] {
        stop_all("p4est could not go on, most likely because memory ran out; its own lines say "
                 "where");
    });
    p4est_init(nullptr, SC_LP_ERROR);
}

} // namespace

} // namespace proxima

int main(int argc, char** argv)
{
    proxima::keep_freed_memory();
    MPI_Init(&argc, &argv);
    proxima::name_errors_of_mpi();
    int exit_status = 1;
    try {
        proxima::CommandLine line(argc, argv);
        proxima::World world(line.wait_seconds);
        proxima::start_p4est();
        const std::span words(argv, static_cast<std::size_t>(argc));
        exit_status = proxima::run(line, words.subspan(1), world);
    } catch (const std::bad_alloc&) {
        proxima::stop_all("memory ran out: use more machines, or fewer ranks on each");
    } catch (const std::exception& error) {
        proxima::stop_all(error.what());
    }
    sc_finalize();
    MPI_Finalize();
    return exit_status;
}
