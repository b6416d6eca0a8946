// The viewer's subcommands.
#pragma once

#include "cli/commands.h"

namespace proxima {

[[nodiscard]] Command add_figures_command(CLI::App& app);
[[nodiscard]] Command add_view_command(CLI::App& app);

} // namespace proxima
