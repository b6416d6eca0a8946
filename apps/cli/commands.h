// The subcommands: each adds its options to the parser and returns what runs it.
#pragma once

#include "cli/session.h"
#include "proxima/result.h"

#include <functional>

namespace CLI {
class App;
} // namespace CLI

namespace proxima {

/// A subcommand that was added to the parser.
struct Command {
    CLI::App* parser = nullptr; ///< says whether it was asked for
    std::function<Status(Session&)> run;
};

[[nodiscard]] Command add_octree_command(CLI::App& app);
[[nodiscard]] Command add_compare_command(CLI::App& app);
[[nodiscard]] Command add_tables_command(CLI::App& app);
[[nodiscard]] Command add_check_command(CLI::App& app);
[[nodiscard]] Command add_repair_command(CLI::App& app);
[[nodiscard]] Command add_minkowski_command(CLI::App& app);
[[nodiscard]] Command add_index_command(CLI::App& app);
[[nodiscard]] Command add_proximity_command(CLI::App& app);
[[nodiscard]] Command add_closest_command(CLI::App& app);
[[nodiscard]] Command add_sdf_command(CLI::App& app);
[[nodiscard]] Command add_deviation_command(CLI::App& app);
[[nodiscard]] Command add_patch_command(CLI::App& app);
[[nodiscard]] Command add_raycast_command(CLI::App& app);
[[nodiscard]] Command add_cull_command(CLI::App& app);
[[nodiscard]] Command add_intersect_command(CLI::App& app);
[[nodiscard]] Command add_scene_command(CLI::App& app);
[[nodiscard]] Command add_contacts_command(CLI::App& app);
[[nodiscard]] Command add_contact_time_command(CLI::App& app);
[[nodiscard]] Command add_touch_command(CLI::App& app);

} // namespace proxima
