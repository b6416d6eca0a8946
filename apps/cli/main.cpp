// proxima: the library on the command line. One subcommand per file.
#include "cli/command_line.h"
#include "viewer/commands.h"

#include <cerrno>
#include <fcntl.h>
#include <unistd.h>

namespace {

/// A standard stream that is closed would be the number of the first file that is opened: what is
/// meant for stdout or stderr would end up in that file. In its place comes what can only be used
/// the wrong way round, so that using it is still an error.
void occupy_closed_streams() noexcept
{
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
        (void)::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    }
}

} // namespace

int main(int argc, char** argv)
{
    occupy_closed_streams();
    constexpr proxima::AddCommand commands[] = {
        proxima::add_octree_command,       proxima::add_compare_command,
        proxima::add_minkowski_command,    proxima::add_index_command,
        proxima::add_proximity_command,    proxima::add_closest_command,
        proxima::add_sdf_command,          proxima::add_patch_command,
        proxima::add_raycast_command,      proxima::add_cull_command,
        proxima::add_intersect_command,    proxima::add_contacts_command,
        proxima::add_contact_time_command, proxima::add_deviation_command,
        proxima::add_scene_command,        proxima::add_touch_command,
        proxima::add_tables_command,       proxima::add_check_command,
        proxima::add_repair_command,       proxima::add_figures_command,
        proxima::add_view_command};
    return proxima::run_command_line(argc, argv, PROXIMA_VERSION, commands);
}
