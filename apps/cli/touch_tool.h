// `proxima touch --tool`: a rigid tool in place of the point, with torques.
#pragma once

#include "cli/session.h"
#include "cli/touch_session.h"
#include "proxima/result.h"
#include "proxima/tool_renderer.h"

#include <CLI/App.hpp>
#include <cstddef>
#include <string>

namespace proxima {

struct ToolCommandOptions {
    std::string tool;      ///< a mesh; "" for none
    double tool_scale = 1; ///< of the tool's coordinates, to the model's unit
    double turn = 0;       ///< degrees, of a simulated hand's wrist
    double max_torque = 0; ///< N m
    double clearance = 1e-5;
    std::size_t max_work = ToolRenderOptions{}.max_work;
    std::string ticks; ///< a table of all ticks; "" for none
};

void add_tool_options(CLI::App& parser, ToolCommandOptions& options);

/// Touches the model with the tool and reports, or plays a session again (device replay:FILE). Each tick
/// of a simulated hand or a replay is looked at by the exact test of whether tool and model meet.
/// `record` is a file for the session; "" for none. Errors: those of make_tool_renderer, of the device
/// and of files.
[[nodiscard]] Status run_tool(const ToolCommandOptions& options, const std::string& model_name,
                              const std::string& record, const TouchSettings& settings,
                              Session& session);

} // namespace proxima
