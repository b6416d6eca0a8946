// What the subcommands share: the common options, exit status, and one line on stderr for whatever
// went wrong.
//
//     0 done    1 a bad input or output    2 wrong usage    129, 130, 143 stopped by a signal
#pragma once

#include "cli/commands.h"

#include <span>

namespace proxima {

/// Adds a subcommand to the parser.
using AddCommand = Command (*)(CLI::App& app);

/// Runs the subcommand that the arguments ask for, and returns the exit status. Never throws.
[[nodiscard]] int run_command_line(int argc, char** argv, const char* version,
                                   std::span<const AddCommand> commands);

} // namespace proxima
