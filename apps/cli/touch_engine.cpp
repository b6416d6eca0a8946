#include "cli/touch_engine.h"

#include "base/text.h"
#include "haptics/channel/engine_transport.h"

#include <CLI/CLI.hpp>
#include <array>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <utility>

namespace proxima {

void add_engine_option(CLI::App& parser, TouchCommandOptions& options)
{
    parser
        .add_option("--engine", options.engine,
                    "Let an engine in another program move the objects and get what is touched: "
                    "udp:PORT, udp:ADDRESS:PORT, or shm:NAME for shared memory")
        ->check([](const std::string& name) { return engine_name_problem(name); })
        ->type_name("CHANNEL");
}

Status check_engine_options(const TouchCommandOptions& options)
{
    if (options.engine.empty()) return {};
    constexpr std::array<std::pair<const char*, const char*>, 4> unfit = {
        {{"--motion", "the engine moves the objects: leave it or --engine out"},
         {"--patch", "is for one model at rest: leave it or --engine out"},
         {"--method", "is for patches of one model at rest: leave it or --engine out"},
         {"--free-running", "an engine keeps real time: leave it or --engine out"}}};
    for (const auto& [option, why] : unfit)
        if (options.is_given(option)) return fail(ErrorCode::invalid_argument, why, option);
    if (options.force == "penalty") {
        return fail(ErrorCode::invalid_argument,
                    "penalty is of one model at rest: leave it or --engine out", "--force");
    }
    return {};
}

std::string engine_text(const TouchResult& result)
{
    if (!result.engine) return {};
    const EngineReport& report = result.engine->report;
    std::string text = fmt::format(
        "engine at {}: {} packets taken, {} lost, {} refused; {} poses, {} materials, {} objects "
        "refused; {} packets sent, {} not\n",
        result.engine->name, report.accepted, report.lost, report.received - report.accepted,
        report.motions, report.materials, report.refused_objects, report.sent, report.unsent);
    if (!result.engine->trouble.empty())
        text += fmt::format("engine: {}\n", result.engine->trouble);
    return text;
}

nlohmann::ordered_json engine_json(const TouchResult& result)
{
    if (!result.engine) return nullptr;
    const EngineReport& report = result.engine->report;
    return {{"name", result.engine->name},
            {"received", report.received},
            {"accepted", report.accepted},
            {"malformed", report.malformed},
            {"other_versions", report.other_versions},
            {"foreign", report.foreign},
            {"duplicated", report.duplicated},
            {"reordered", report.reordered},
            {"leapt", report.leapt},
            {"lost", report.lost},
            {"sessions", report.sessions},
            {"motions", report.motions},
            {"materials", report.materials},
            {"refused_objects", report.refused_objects},
            {"sent", report.sent},
            {"unsent", report.unsent},
            {"trouble", result.engine->trouble}};
}

} // namespace proxima
