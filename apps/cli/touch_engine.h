// A session's channel to an engine in another program (touch_scene.h), as the command line and the
// report have it.
#pragma once

#include "cli/touch_options.h"
#include "cli/touch_session.h"
#include "proxima/result.h"

#include <CLI/App.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace proxima {

/// A scene that an engine moves reaches so many of its diagonals beyond where its objects begin.
inline constexpr double engine_room = 16;

/// Adds --engine. A name that is none is wrong usage.
void add_engine_option(CLI::App& parser, TouchCommandOptions& options);

/// Error invalid_argument for an option that does not go with --engine.
[[nodiscard]] Status check_engine_options(const TouchCommandOptions& options);

/// What came of the channel, in a line or two; "" where there was none.
[[nodiscard]] std::string engine_text(const TouchResult& result);
/// Null where there was no channel.
[[nodiscard]] nlohmann::ordered_json engine_json(const TouchResult& result);

} // namespace proxima
