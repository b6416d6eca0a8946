// The points that a command asks about: --points FILE, or --point X,Y,Z on the command line.
#pragma once

#include "cli/number_table.h"
#include "cli/session.h"
#include "proxima/result.h"

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace proxima {

struct PointOptions {
    std::string file;
    std::vector<std::string> points;
};

/// Adds both options, of which one may be given.
void add_point_options(CLI::App& parser, PointOptions& options);

/// To be called when options are read: throws what the parser throws for a missing one.
void check_points_given(const PointOptions& options);

/// A table of three columns. Errors as read_number_table.
[[nodiscard]] Result<NumberTable> read_points(const PointOptions& options, Session& session);

} // namespace proxima
