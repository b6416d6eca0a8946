// What `proxima touch` is told on its command line, and what of it goes together.
#pragma once

#include "cli/query_method.h"
#include "cli/touch_objects.h"
#include "cli/touch_session.h"
#include "cli/touch_tool.h"
#include "proxima/result.h"

#include <CLI/App.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace proxima {

struct TouchCommandOptions {
    std::string model;
    ObjectOptions objects;
    ToolCommandOptions tool;
    std::string device;
    std::string engine;    ///< the channel to one; "" for none
    std::string library;   ///< of hd and dhd
    std::string limits;    ///< "" for the device's own
    std::string axes;      ///< "" for the device's own
    std::string stillness; ///< "" for the device's own
    double scale = 1;
    int clutch = 0; ///< button from 1; 0 for none
    bool list = false;
    bool self_test = false;
    bool yes = false; ///< nobody confirms the steps of a self-test
    double seconds = 5;
    std::uint64_t seed = 1;
    HandModel hand; ///< of hand:SCRIPT, with the device that it holds
    double stiffness = ForceOptions{}.stiffness;
    double damping = ForceOptions{}.damping;
    double radius = 0; ///< m
    double friction = RenderOptions{}.static_friction;
    bool shading = false;
    bool lists = false; ///< of indexes that are built
    std::string force = "proxy";
    std::string guard = "on";
    bool free_running = false;
    bool verbose = false;
    std::string record;
    std::string picture;                     ///< a plot of the session, or the table of its ticks
    std::string patches;                     ///< kinds; "" for the direct mode
    QueryMethod method = QueryMethod::index; ///< of patches
    double collision_rate = PatchSettings{}.collision_rate;
    double graphics_rate = TouchSettings{}.graphics_rate;
    std::vector<std::string> given; ///< names of the options that were given

    [[nodiscard]] bool is_given(std::string_view name) const;
};

/// Adds all but MODEL, --device, --list-devices and those of objects. A value out of its range is
/// wrong usage.
void add_touch_options(CLI::App& parser, TouchCommandOptions& options);

/// Error invalid_argument for an option that would be without any effect.
[[nodiscard]] Status check_options(const TouchCommandOptions& options);

/// "off", "observe" or "on".
[[nodiscard]] std::string_view guard_name(Guard guard) noexcept;

/// The option by which patches were asked for: --patch, or --method alone.
[[nodiscard]] const char* option_of_patches(const TouchCommandOptions& options);

[[nodiscard]] TouchSettings settings_of(const TouchCommandOptions& options);

/// What a material has that says less of itself.
[[nodiscard]] SurfaceMaterial usual_material(const TouchCommandOptions& options);

/// Accepts one finite number in the range.
[[nodiscard]] CLI::Validator number_from(double least, double most);

/// Adds an option for such a number; `unit` stands for it in the help.
void add_number(CLI::App& parser, const char* name, double& value, const char* what,
                const char* unit, double least, double most);

} // namespace proxima
