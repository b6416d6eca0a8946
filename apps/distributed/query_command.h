// proxima-mpi closest, rays and sign: questions to a mesh that is spread over the ranks.
#pragma once

#include "distributed/table_blocks.h"
#include "distributed/world.h"

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace proxima {

struct QueryOptions {
    std::string model;
    std::string triangles; ///< a .npy file where the model is one of vertices, or empty
    TableSource table;     ///< of points or rays
    std::string out = "-"; ///< "-" for stdout
    int routing_depth = 5;
    bool is_verified = false;
};

/// Each adds a subcommand. What it returns answers the table of the parsed arguments, writes the
/// answers on rank 0 and is collective.
[[nodiscard]] std::function<Status(World&)> add_closest_command(CLI::App& app);
[[nodiscard]] std::function<Status(World&)> add_rays_command(CLI::App& app);
[[nodiscard]] std::function<Status(World&)> add_sign_command(CLI::App& app);

} // namespace proxima
