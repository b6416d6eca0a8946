// proxima: the library on the command line. One subcommand per file.
#include "cli/command_line.h"
#include "viewer/commands.h"

int main(int argc, char** argv)
{
    constexpr proxima::AddCommand commands[] = {
        proxima::add_octree_command,    proxima::add_compare_command,
        proxima::add_minkowski_command, proxima::add_index_command,
        proxima::add_proximity_command, proxima::add_closest_command,
        proxima::add_patch_command,     proxima::add_raycast_command,
        proxima::add_cull_command,      proxima::add_intersect_command,
        proxima::add_touch_command,     proxima::add_tables_command,
        proxima::add_check_command,     proxima::add_repair_command,
        proxima::add_figures_command,   proxima::add_view_command};
    return proxima::run_command_line(argc, argv, PROXIMA_VERSION, commands);
}
